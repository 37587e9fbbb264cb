#include "tools/patinate/study/study_context.h"

#include <algorithm>
#include <cctype>
#include <system_error>
#include <utility>

#include "patinate/core/error.h"
#include "tools/patinate/command_line/path_kind.h"

namespace patinate::cli {

namespace fs = std::filesystem;

StudyContext::StudyContext(fs::path file, const fs::path& folder, std::vector<std::string>& problems)
    : file_(std::move(file)),
      given_folder_(folder),
      folder_(fs::weakly_canonical(fs::absolute(folder))),
      problems_(problems) {}

void StudyContext::attempt(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& e) {
    problems_.emplace_back(e.what());
  }
}

void StudyContext::problem(const JsonReader& json, const std::string& text) {
  problems_.push_back(file_.string() + ": " + json.pointer() + ": " + text);
}

std::string StudyContext::word_of(const fs::path& path) const {
  const fs::path whole = fs::absolute(path).lexically_normal();
  const fs::path named = whole.lexically_relative(fs::absolute(given_folder_).lexically_normal());
  std::error_code error;
  if (fs::equivalent((folder_ / named).lexically_normal(), whole, error)) return named.generic_string();
  return fs::relative(fs::weakly_canonical(whole), folder_).generic_string();  // A link lies between them.
}

void StudyContext::check_place(const JsonReader& json, const fs::path& path) {
  try {
    require_exists(path);
  } catch (const InputError& e) {
    return problem(json, e.what());
  }
  const fs::path place = fs::weakly_canonical(fs::absolute(path));
  if (std::mismatch(folder_.begin(), folder_.end(), place.begin(), place.end()).first == folder_.end())
    problem(json, path.string() + " lies in the study's own folder, so that the study would wait for itself");
}

std::string slug(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool is_kept = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '_';
    if (is_kept)
      out += c;
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (!out.empty() && (out.back() == '_' || out.back() == '.')) out.pop_back();
  const std::size_t begin = out.find_first_not_of('.');
  return begin == std::string::npos ? "x" : out.substr(begin);
}

}  // namespace patinate::cli
