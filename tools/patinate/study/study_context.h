/// \file
/// What all parts of a study's file need to be read: where it lies, and where its commands run.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/json.h"

namespace patinate::cli {

/// Collects what is wrong with a study.
class StudyContext {
 public:
  /// @param file,folder,problems  As read_study()'s.
  StudyContext(std::filesystem::path file, const std::filesystem::path& folder, std::vector<std::string>& problems);

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] bool has_problems() const { return !problems_.empty(); }
  [[nodiscard]] std::size_t num_problems() const { return problems_.size(); }
  void problem(const std::string& line) { problems_.push_back(line); }
  void problem(const JsonReader& json, const std::string& text);
  /// What `work` throws of input is a problem.
  void attempt(const std::function<void()>& work);

  /// A path as commands say it, which run in the study's folder.
  [[nodiscard]] std::string word_of(const std::filesystem::path& path) const;
  /// It is a problem where nothing is, or what the study makes.
  void check_place(const JsonReader& json, const std::filesystem::path& path);

 private:
  std::filesystem::path file_, given_folder_;
  std::filesystem::path folder_;  ///< The same, without links.
  std::vector<std::string>& problems_;
};

/// What of a text may stand in the name of a cell.
[[nodiscard]] std::string slug(std::string_view text);

}  // namespace patinate::cli
