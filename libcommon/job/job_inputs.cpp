#include "libcommon/job/job_inputs.h"

#include "libcommon/core/text.h"

namespace patinate {

JobInputs::JobInputs(std::string_view stage, std::int64_t version) {
  hash_.add(stage).add(version);
  append("patinate's " + std::string(stage), "version " + std::to_string(version));
}

JobInputs JobInputs::counted_without_names(std::string_view stage) {
  JobInputs inputs;
  inputs.hash_.add(stage);
  inputs.has_names_ = false;
  return inputs;
}

JobInputs& JobInputs::add_value(const std::string& name, const std::string& text) {
  if (has_names_) hash_.add("value").add(name);
  hash_.add(text);
  append(name, text);
  return *this;
}

JobInputs& JobInputs::add_options(const std::vector<std::pair<std::string, std::string>>& values) {
  for (const auto& [name, value] : values) add_value(dashed(name), value);
  return *this;
}

JobInputs& JobInputs::add_content(std::string_view role, const std::string& name, const std::string& key) {
  if (has_names_) hash_.add("content").add(role);
  hash_.add(key);
  append(name, key);
  return *this;
}

JobInputs& JobInputs::add_file(std::string_view role, const std::filesystem::path& file,
                               const std::filesystem::path& shown_from) {
  return add_content(role, shown_name(file, shown_from), hash_file(file));
}

void JobInputs::append(const std::string& name, const std::string& key) {
  const int use = ++num_uses_[name];
  list_.push_back({use == 1 ? name : name + " (" + std::to_string(use) + ")", key});
}

std::string shown_name(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const std::filesystem::path relative = file.lexically_normal().lexically_relative(folder.lexically_normal());
  const bool is_inside = !folder.empty() && !relative.empty() && *relative.begin() != "..";
  return is_inside ? relative.string() : file.filename().string();
}

}  // namespace patinate
