#include "libcommon/core/files.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <string_view>
#include <system_error>

#include "libcommon/core/read_limit.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// Digits from `begin` on, and behind a point or comma those of a fraction: "0.25", but no part of "1.2.3".
struct NumberText {
  std::string_view whole, fraction;
  std::size_t end = 0;
};

NumberText number_at(std::string_view s, std::size_t begin, bool has_fractions) {
  const auto end_of_digits = [&](std::size_t k) {
    while (k < s.size() && is_digit(s[k])) ++k;
    return k;
  };
  const auto is_point = [&](std::size_t k) { return k < s.size() && (s[k] == '.' || s[k] == ','); };
  const std::size_t end = end_of_digits(begin);
  NumberText number{s.substr(begin, end - begin), {}, end};
  const std::size_t end_of_fraction = is_point(end) ? end_of_digits(end + 1) : end;
  const bool is_behind_point = begin > 1 && is_point(begin - 1) && is_digit(s[begin - 2]);
  const bool is_before_point = is_point(end_of_fraction) && end_of_digits(end_of_fraction + 1) > end_of_fraction + 1;
  if (!has_fractions || end_of_fraction <= end + 1 || is_behind_point || is_before_point) return number;
  number.fraction = s.substr(end + 1, end_of_fraction - end - 1);
  number.end = end_of_fraction;
  return number;
}

/// Sign of a - b: as whole numbers, then as fractions.
int compare_numbers(const NumberText& a, const NumberText& b) {
  const auto without_zeros = [](std::string_view s) { return s.substr(std::min(s.find_first_not_of('0'), s.size())); };
  const std::string_view x = without_zeros(a.whole), y = without_zeros(b.whole);
  if (x.size() != y.size()) return x.size() < y.size() ? -1 : 1;
  if (const int order = x.compare(y); order != 0) return order;
  const auto digit = [](std::string_view s, std::size_t k) { return k < s.size() ? s[k] : '0'; };
  for (std::size_t k = 0; k < std::max(a.fraction.size(), b.fraction.size()); ++k) {
    if (digit(a.fraction, k) != digit(b.fraction, k)) return digit(a.fraction, k) < digit(b.fraction, k) ? -1 : 1;
  }
  return 0;
}

/// How the numbers of names are read.
struct NumberRule {
  bool has_fractions = false;
  /// Texts before numbers of which some have a sign: "-5min" and "T+10min" beside "0min" and "T-5min".
  std::set<std::string, std::less<>> signed_after = {};

  /// 1 where a sign stands before a number, else 0.
  [[nodiscard]] std::size_t sign_at(std::string_view name, std::size_t k) const {
    const bool is_sign = (name[k] == '-' || name[k] == '+') && k + 1 < name.size() && is_digit(name[k + 1]);
    return is_sign && signed_after.contains(name.substr(0, k)) ? 1 : 0;
  }
};

/// Numbers compare as numbers, other characters by code; ties by plain comparison.
bool natural_less(const std::string& a, const std::string& b, const NumberRule& rule) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const std::size_t sign_a = rule.sign_at(a, i), sign_b = rule.sign_at(b, j);
    if (is_digit(a[i + sign_a]) && is_digit(b[j + sign_b])) {
      const bool is_below_a = a[i] == '-', is_below_b = b[j] == '-';
      const NumberText x = number_at(a, i + sign_a, rule.has_fractions),
                       y = number_at(b, j + sign_b, rule.has_fractions);
      if (is_below_a != is_below_b) return is_below_a;
      if (const int order = compare_numbers(x, y); order != 0) return is_below_a ? order > 0 : order < 0;
      i = x.end, j = y.end;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

/// Whether the points in names stand before fractions. They do not where "1.10" stands beside "1.9": that counts on.
bool have_fractions(const std::vector<fs::path>& files) {
  bool has_ten = false, has_digit = false;
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    for (std::size_t k = 0; k < name.size();) {
      if (!is_digit(name[k])) {
        ++k;
        continue;
      }
      const NumberText number = number_at(name, k, true);
      has_ten = has_ten || number.fraction == "10";
      has_digit = has_digit || (number.fraction.size() == 1 && number.fraction != "0");
      k = number.end;
    }
  }
  return !(has_ten && has_digit);
}

/// A sign stands where one name has `-` and another one `+` or the number alone behind the same beginning. Behind a
/// digit it is none.
std::set<std::string, std::less<>> signed_after(const std::vector<fs::path>& files) {
  std::set<std::string, std::less<>> below, others;
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    for (std::size_t k = 0; k < name.size(); ++k) {
      const bool is_behind_digit = k > 0 && is_digit(name[k - 1]);
      const bool is_before_digit = k + 1 < name.size() && is_digit(name[k + 1]);
      if (is_behind_digit) continue;
      if (name[k] == '-' && is_before_digit) below.insert(name.substr(0, k));
      if (is_digit(name[k]) || (name[k] == '+' && is_before_digit)) others.insert(name.substr(0, k));
    }
  }
  std::set<std::string, std::less<>> both;
  std::set_intersection(below.begin(), below.end(), others.begin(), others.end(), std::inserter(both, both.end()));
  return both;
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
  check_may_read(folder.empty() ? fs::path(".") : folder);
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
  const NumberRule rule{have_fractions(found), signed_after(found)};
  std::sort(found.begin(), found.end(), [&](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string(), rule);
  });
  return found;
}

}  // namespace patinate
