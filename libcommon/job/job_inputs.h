/// \file
/// What a job depends on, named as a user would name it, and the key made of it: one list, so that neither forgets
/// anything.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libcommon/core/hash.h"
#include "libcommon/job/job.h"

namespace patinate {

/// Collects dependencies in a fixed order. Values count by name and text; files by role and content, so that a renamed
/// photograph changes no key.
class JobInputs {
 public:
  /// @param stage  "ingest"; @param version  raised whenever the same input gives other output.
  JobInputs(std::string_view stage, std::int64_t version);
  /// Without a version, and with keys and texts that count alone: names, roles and options are only shown. So `ingest`
  /// and `unlight` have counted from the beginning, and what they made stays up to date; a new stage counts names, too.
  static JobInputs counted_without_names(std::string_view stage);

  JobInputs& add_value(const std::string& name, const std::string& text);
  /// Values of a described options struct, under the names of the command line ("--spatial-sigma").
  JobInputs& add_options(const std::vector<std::pair<std::string, std::string>>& values);
  /// @param name  Shown, no part of the key. @param key  Of the content, see hash_file(); may hold more, e.g. a time.
  JobInputs& add_content(std::string_view role, const std::string& name, const std::string& key);
  /// @param shown_from  The name shown is the path relative to this folder. @throws IoError if the file cannot be read.
  JobInputs& add_file(std::string_view role, const std::filesystem::path& file,
                      const std::filesystem::path& shown_from = {});

  [[nodiscard]] std::string key() const { return hash_.hex(); }
  [[nodiscard]] const std::vector<JobDependency>& list() const { return list_; }
  /// A plan without items that depends on all that was added so far. @param manifest  As JobPlan's.
  [[nodiscard]] JobPlan plan(const std::filesystem::path& output, const std::string& manifest) const {
    JobPlan plan;
    plan.output = output;
    plan.manifest = manifest;
    plan.key = key();
    plan.depends_on = list_;
    return plan;
  }

 private:
  JobInputs() = default;
  /// Equal names get numbers: "a.jpg", "a.jpg (2)".
  void append(const std::string& name, const std::string& key);

  ContentHash hash_;
  bool has_names_ = true;  ///< In the key.
  std::vector<JobDependency> list_;
  std::map<std::string, int> num_uses_;
};

/// A file's name as one would say it from `folder`: "photos/day07.jpg"; its bare name when it lies elsewhere.
[[nodiscard]] std::string shown_name(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace patinate
