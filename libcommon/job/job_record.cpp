#include "libcommon/job/job_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/hash.h"
#include "libcommon/core/input_watch.h"
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
  if (json.contains("joined")) record.joined = read_texts(json.at("joined"));
  if (json.contains("bytes")) {
    for (const auto& [name, bytes] : json.at("bytes").items()) record.bytes[name] = bytes.get<std::uint64_t>();
  }
  record.key = json.at("key");
  return record;
}

/// Files of a folder, relative to it, but for book-keeping, caches, and what differs from run to run.
std::vector<fs::path> recorded_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (auto it = fs::recursive_directory_iterator(folder); it != fs::recursive_directory_iterator(); ++it) {
    const fs::path relative = it->path().lexically_relative(folder);
    if (it->is_directory() && relative.filename().string().starts_with('.')) it.disable_recursion_pending();
    if (!it->is_regular_file() || relative == kJobRecordFile || relative == kRunRecordFile) continue;
    files.push_back(relative);
  }
  return files;
}

/// Key by path of everything that the record knows.
std::map<std::string, std::string> known_keys(const JobRecord& record) {
  std::map<std::string, std::string> keys = record.joined;
  for (const auto& [name, item] : record.items) keys.insert(item.files.begin(), item.files.end());
  return keys;
}

/// A small file of an item that the join has written anew, such as a report, is the join's.
void forget_rewritten(const fs::path& folder, JobRecord& record) {
  constexpr std::uintmax_t kMaxBytes = 1 << 20;
  for (auto& [name, item] : record.items) {
    std::erase_if(item.files, [&](const auto& file) {
      std::error_code error;
      const fs::path path = folder / file.first;
      return fs::file_size(path, error) <= kMaxBytes && !error && hash_file(path) != file.second;
    });
  }
}

bool has_content(const fs::path& file, const std::string& key) {
  try {
    return hash_file(file) == key;
  } catch (const IoError&) {
    return false;
  }
}

}  // namespace

JobRecord read_job_record(const fs::path& folder, const std::string& key) {
  std::error_code error;
  if (key.empty() || !fs::is_regular_file(folder / kJobRecordFile, error)) return {};
  const UnwatchedReads of_output;
  try {
    JobRecord record = parse_record(load_json(folder / kJobRecordFile));
    return record.key == key ? record : JobRecord{};
  } catch (const IoError&) {
    return {};  // A damaged record vouches for nothing: everything is done again.
  } catch (const Json::exception&) {
    return {};
  }
}

void write_job_record(const fs::path& folder, JobRecord record, const std::string& manifest) {
  forget_rewritten(folder, record);
  const std::map<std::string, std::string> made = known_keys(record);
  for (const fs::path& file : recorded_files(folder)) {
    const std::string name = file.generic_string();
    if (name == manifest) continue;
    record.bytes[name] = fs::file_size(folder / file);
    if (!made.contains(name)) record.joined[name] = hash_file(folder / file);
  }
  Json depends_on = Json::array(), items = Json::object();
  for (const JobDependency& d : record.depends_on) depends_on.push_back({{"name", d.name}, {"key", d.key}});
  for (const auto& [name, done] : record.items) {
    Json files = Json::object();
    for (const auto& [file, key] : done.files) files[file] = key;
    items[name] = {{"key", done.key}, {"files", files}};
  }
  save_json(folder / kJobRecordFile, Json{{"format", kFormat},
                                          {"version", 1},
                                          {"depends_on", depends_on},
                                          {"items", items},
                                          {"joined", record.joined},
                                          {"bytes", record.bytes},
                                          {"key", record.key}});
}

FolderDamage damage_of(const fs::path& folder, const JobRecord& record, Looked looked) {
  const UnwatchedReads of_output;
  FolderDamage damage;
  for (const auto& [name, key] : known_keys(record)) {
    std::error_code error;
    const auto bytes = record.bytes.find(name);
    if (!fs::is_regular_file(folder / name, error)) {
      damage.lost.push_back(name);
    } else if ((bytes != record.bytes.end() && fs::file_size(folder / name, error) != bytes->second) ||
               (looked == Looked::AtContent && !has_content(folder / name, key))) {
      damage.altered.push_back(name);
    }
  }
  return damage;
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
  const UnwatchedReads of_output;
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
