#include "libcommon/core/files.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "libcommon/core/error.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// Forces a file's bytes to the disk, so that a full disk is noticed before the rename. @returns whether they are there
bool flush_to_disk(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool ok = fd >= 0 && ::fsync(fd) == 0;
  if (fd >= 0) ::close(fd);
  return ok;
}

constexpr std::string_view kTemporary = ".tmp";  // Followed by the writer's process id.

std::string temporary_stem(const fs::path& path) { return "." + path.stem().string() + std::string(kTemporary); }

/// A temporary file whose writer was killed.
bool is_abandoned(const fs::path& temporary) {
  const std::string name = temporary.stem().string();
  const std::size_t at = name.rfind(kTemporary);
  if (at == std::string::npos) return false;
  const std::optional<double> writer = parse_number(name.substr(at + kTemporary.size()));
  if (!writer || !(*writer >= 1.0 && *writer <= std::numeric_limits<pid_t>::max())) return false;
  return ::kill(static_cast<pid_t>(*writer), 0) != 0 && errno == ESRCH;
}

void remove_abandoned_files(const fs::path& folder, const std::function<bool(const fs::path&)>& is_one) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (is_one(it->path()) && is_abandoned(it->path())) fs::remove(it->path(), ignored);
  }
}

/// Removes temporary files for the same path whose writers were killed.
void remove_leftovers(const fs::path& folder, const fs::path& path) {
  const std::string stem = temporary_stem(path);
  remove_abandoned_files(folder, [&](const fs::path& p) { return p.filename().string().starts_with(stem) && p.extension() == path.extension(); });
}

/// The temporary files of this process. Never destroyed: a thread may still write when the process ends.
struct Unfinished {
  std::mutex mutex;
  std::multiset<fs::path> paths;
};
Unfinished& unfinished() {
  static auto* const all = new Unfinished;
  return *all;
}

/// Call under the mutex.
void forget(const fs::path& temporary) {
  auto& paths = unfinished().paths;
  if (const auto it = paths.find(temporary); it != paths.end()) paths.erase(it);
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
  const std::lock_guard lock(unfinished().mutex);
  unfinished().paths.insert(temporary_);
}

AtomicFile::~AtomicFile() {
  if (is_finished_) return;
  std::error_code error;
  const std::lock_guard lock(unfinished().mutex);
  fs::remove(temporary_, error);
  forget(temporary_);
}

void AtomicFile::finish() {
  const bool is_flushed = flush_to_disk(temporary_);
  const std::lock_guard lock(unfinished().mutex);
  if (!is_flushed) throw CannotComplete(path_.string() + ": cannot be written; is the disk full?");
  move_to_place();
}

void AtomicFile::finish_unsynced() {
  const std::lock_guard lock(unfinished().mutex);
  move_to_place();
}

void AtomicFile::move_to_place() {
  std::error_code error;
  fs::rename(temporary_, path_, error);
  if (error) throw CannotComplete(path_.string() + ": cannot be written; " + error.message());
  is_finished_ = true;
  forget(temporary_);
}

void abandon_atomic_files() {
  unfinished().mutex.lock();  // For good.
  std::error_code error;
  for (const fs::path& temporary : unfinished().paths) fs::remove(temporary, error);
}

void remove_abandoned(const fs::path& folder, std::string_view prefix) {
  const std::string start = "." + std::string(prefix);
  remove_abandoned_files(folder, [&](const fs::path& p) { return p.filename().string().starts_with(start); });
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
  check_may_read(path);
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
