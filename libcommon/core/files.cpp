#include "libcommon/core/files.h"

#include <algorithm>
#include <fstream>
#include <system_error>

#include "libcommon/core/read_limit.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// Digits compare as numbers, other characters by code; ties by plain comparison.
bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto end_of_digits = [](const std::string& s, std::size_t k) {
        while (k < s.size() && is_digit(s[k])) ++k;
        return k;
      };
      std::size_t i0 = i, j0 = j;
      i = end_of_digits(a, i);
      j = end_of_digits(b, j);
      while (i0 < i && a[i0] == '0') ++i0;
      while (j0 < j && b[j0] == '0') ++j0;
      if (i - i0 != j - j0) return i - i0 < j - j0;
      const int order = a.compare(i0, i - i0, b, j0, j - j0);
      if (order != 0) return order < 0;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

}  // namespace

std::string read_file(const fs::path& path, std::uint64_t max_bytes) {
  check_may_read(path);
  require_regular_file(path);
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw IoError(path.string(), "cannot be read; check its permissions");
  const std::streamoff size = in.tellg();
  if (size < 0 || static_cast<std::uint64_t>(size) > max_bytes) {
    throw IoError(path.string(), "is too large; at most " + std::to_string(max_bytes) + " bytes");
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  in.seekg(0);
  in.read(bytes.data(), size);
  if (!in) throw IoError(path.string(), "reading failed part way");
  return bytes;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

fs::path manifest_folder(const fs::path& path, std::string_view manifest_name) {
  return path.filename() == manifest_name ? folder_of(path) : path;
}

bool matches_pattern(std::string_view name, std::string_view pattern) {
  std::size_t n = 0, p = 0, star = std::string_view::npos, star_n = 0;
  while (n < name.size()) {
    if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n]) && pattern[p] != '*') {
      ++n, ++p;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      star_n = n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++star_n;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

std::vector<fs::path> list_files(const fs::path& folder, std::string_view pattern) {
  std::error_code error;
  // A pattern without a folder, "*.png", has an empty one: that is the working folder, and its files have no folder
  // either.
  fs::directory_iterator it(folder.empty() ? fs::path(".") : folder, error);
  if (error) throw IoError(folder.string(), "cannot be listed; " + error.message());
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : it) {
    // A dangling link is listed too: whoever reads it says so, and the files after it keep their places.
    const fs::path name = entry.path().filename();
    if (!entry.is_directory(error) && matches_pattern(name.string(), pattern)) found.push_back(folder / name);
  }
  std::sort(found.begin(), found.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return found;
}

}  // namespace patinate
