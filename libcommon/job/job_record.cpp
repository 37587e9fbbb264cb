#include "libcommon/job/job_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/hash.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFormat = "patinate.job";

std::map<std::string, std::string> read_texts(const Json& json) {
  std::map<std::string, std::string> texts;
  for (const auto& [name, value] : json.items()) texts[name] = value.get<std::string>();
  return texts;
}

JobRecord parse_record(const Json& json) {
  JobRecord record;
  if (json.at("format") != kFormat || json.at("version") != 1) return record;
  for (const Json& d : json.at("depends_on")) record.depends_on.push_back({d.at("name"), d.at("key")});
  for (const auto& [name, item] : json.at("items").items())
    record.items[name] = {item.at("key"), read_texts(item.at("files"))};
  record.key = json.at("key");
  return record;
}

}  // namespace

JobRecord read_job_record(const fs::path& folder, const std::string& key) {
  std::error_code error;
  if (key.empty() || !fs::is_regular_file(folder / kJobRecordFile, error)) return {};
  try {
    JobRecord record = parse_record(load_json(folder / kJobRecordFile));
    return record.key == key ? record : JobRecord{};
  } catch (const IoError&) {
    return {};  // A damaged record vouches for nothing: everything is done again.
  } catch (const Json::exception&) {
    return {};
  }
}

void write_job_record(const fs::path& folder, const JobRecord& record) {
  Json depends_on = Json::array(), items = Json::object();
  for (const JobDependency& d : record.depends_on) depends_on.push_back({{"name", d.name}, {"key", d.key}});
  for (const auto& [name, done] : record.items) {
    Json files = Json::object();
    for (const auto& [file, key] : done.files) files[file] = key;
    items[name] = {{"key", done.key}, {"files", files}};
  }
  save_json(
      folder / kJobRecordFile,
      Json{{"format", kFormat}, {"version", 1}, {"depends_on", depends_on}, {"items", items}, {"key", record.key}});
}

std::optional<std::vector<fs::path>> made_files(const JobItem& item, const DoneItem& done) {
  std::vector<fs::path> files = item.outputs;
  for (const fs::path& file : item.optional_outputs) {
    if (done.files.contains(file.generic_string())) files.push_back(file);
  }
  const bool has_all = std::all_of(files.begin(), files.end(),
                                   [&](const fs::path& file) { return done.files.contains(file.generic_string()); });
  return has_all && files.size() == done.files.size() ? std::optional(std::move(files)) : std::nullopt;
}

bool is_unchanged(const fs::path& folder, const std::vector<fs::path>& outputs, const DoneItem& done) {
  return std::all_of(outputs.begin(), outputs.end(), [&](const fs::path& output) {
    const auto known = done.files.find(output.generic_string());
    std::error_code error;
    if (known == done.files.end() || !fs::is_regular_file(folder / output, error)) return false;
    try {
      return hash_file(folder / output) == known->second;
    } catch (const IoError&) {
      return false;
    }
  });
}

std::vector<JobChange> changes_between(const std::vector<JobDependency>& before,
                                       const std::vector<JobDependency>& now) {
  std::map<std::string, std::string> old;
  for (const JobDependency& d : before) old[d.name] = d.key;
  std::vector<JobChange> changes;
  for (const JobDependency& d : now) {
    const auto it = old.find(d.name);
    if (it == old.end()) {
      changes.push_back({JobChange::Kind::Added, d.name, "", d.key});
      continue;
    }
    if (it->second != d.key) changes.push_back({JobChange::Kind::Changed, d.name, it->second, d.key});
    old.erase(it);
  }
  for (const JobDependency& d : before) {
    if (old.contains(d.name)) changes.push_back({JobChange::Kind::Removed, d.name, d.key, ""});
  }
  return changes;
}

}  // namespace patinate
