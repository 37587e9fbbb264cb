#include "libcommon/core/files.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// Forces a file's bytes to the disk, so that a full disk is noticed before the rename.
void flush_to_disk(const fs::path& path, const fs::path& shown) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool ok = fd >= 0 && ::fsync(fd) == 0;
  if (fd >= 0) ::close(fd);
  if (!ok) throw CannotComplete(shown.string() + ": cannot be written; is the disk full?");
}

std::string temporary_stem(const fs::path& path) { return "." + path.stem().string() + ".tmp"; }

/// Removes temporary files for the same path whose writers were killed.
void remove_leftovers(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  const std::string stem = temporary_stem(path);
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with(stem) || it->path().extension() != path.extension()) continue;
    const std::optional<double> writer = parse_number(name.substr(stem.size(), name.find('.', stem.size()) - stem.size()));
    if (writer && ::kill(static_cast<pid_t>(*writer), 0) != 0 && errno == ESRCH) fs::remove(it->path(), error);
  }
}

bool matches(std::string_view name, std::string_view pattern) {
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

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

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

AtomicFile::AtomicFile(fs::path path) : path_(std::move(path)) {
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw CannotComplete(path_.string() + ": cannot be written; the folder " + folder.string() + " does not exist");
  }
  if (fs::is_directory(path_, error)) throw CannotComplete(path_.string() + ": cannot be written; it is a folder");
  if (fs::exists(path_, error) && !fs::is_regular_file(path_, error)) {
    throw CannotComplete(path_.string() + ": cannot be written; it is no regular file");
  }
  remove_leftovers(folder, path_);
  temporary_ = folder / (temporary_stem(path_) + std::to_string(::getpid()) + path_.extension().string());
}

AtomicFile::~AtomicFile() {
  std::error_code error;
  if (!is_finished_) fs::remove(temporary_, error);
}

void AtomicFile::finish() {
  flush_to_disk(temporary_, path_);
  std::error_code error;
  fs::rename(temporary_, path_, error);
  if (error) throw CannotComplete(path_.string() + ": cannot be written; " + error.message());
  is_finished_ = true;
}

void write_atomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  AtomicFile file(path);
  try {
    write(file.temporary());
  } catch (const fs::filesystem_error& e) {
    throw CannotComplete(path.string() + ": cannot be written; " + e.code().message());
  }
  file.finish();
}

void write_atomically(const fs::path& path, std::string_view bytes) {
  write_atomically(path, [&](const fs::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw CannotComplete(path.string() + ": cannot be written; is the folder writable and the disk not full?");
  });
}

std::string read_file(const fs::path& path, std::uint64_t max_bytes) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw IoError(path.string(), "is a folder; give a file");
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) {
    throw IoError(path.string(), fs::exists(path, error) ? "cannot be read; check its permissions" : "does not exist");
  }
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

fs::path manifest_folder(const fs::path& path, std::string_view manifest_name) {
  if (path.filename() != manifest_name) return path;
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

std::vector<fs::path> list_files(const fs::path& folder, std::string_view pattern) {
  std::error_code error;
  fs::directory_iterator it(folder, error);
  if (error) throw IoError(folder.string(), "cannot be listed; " + error.message());
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : it) {
    // A dangling link is listed too: whoever reads it says so, and the files after it keep their places.
    if (!entry.is_directory(error) && matches(entry.path().filename().string(), pattern)) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return found;
}

}  // namespace patinate
