#include "libcommon/core/temporary_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

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

constexpr std::string_view kTemporary = ".tmp";  // Followed by who writes.
constexpr std::chrono::hours kLongUnwritten{7 * 24};
constexpr std::size_t kMaxOfStem = 180;  // The name of a file has at most 255 bytes.

std::string temporary_stem(const fs::path& path) {
  return "." + path.stem().string().substr(0, kMaxOfStem) + std::string(kTemporary);
}

/// Who writes a temporary file: MACHINE-PID-PROCESS-NUMBER. Process ids mean something on one machine only.
struct Writer {
  std::string machine;  ///< 8 hexadecimal digits; "" = not known.
  pid_t pid = 0;
  std::string process;  ///< 8 random hexadecimal digits of the process: another one had the same id before.
};

std::string hex_digits(std::uint64_t value) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(value ^ (value >> 32)));
  return text.data();
}

std::string first_line(const char* file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// Everything in which a process id has one meaning: a start of a machine, and in it a namespace (containers have their
/// own).
std::string this_machine() {
  std::error_code error;
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  const std::string text =
      host.data() + ("/" + machine_start()) + "/" + fs::read_symlink("/proc/self/ns/pid", error).string();
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hex_digits(hash);
}

/// This process, as others see it on its files.
Writer this_writer() {
  static const std::string machine = this_machine(), process = hex_digits(std::random_device()());
  return {machine, ::getpid(), process};
}

std::string new_writer_text() {
  static std::atomic<unsigned> number{0};
  const Writer writer = this_writer();
  return writer.machine + "-" + std::to_string(writer.pid) + "-" + writer.process + "-" + std::to_string(number++);
}

/// @param text  As new_writer_text() makes it.
std::optional<Writer> parse_writer(const std::string& text) {
  const auto is_number = [](const std::string& s) {
    return !s.empty() && s.size() < 10 && s.find_first_not_of("0123456789") == std::string::npos;
  };
  const auto is_hex = [](const std::string& s) {
    return s.size() == 8 && s.find_first_not_of("0123456789abcdef") == std::string::npos;
  };
  const std::vector<std::string> parts = split(text, '-');
  if (parts.size() == 1 && is_number(parts[0])) return Writer{};  // Name by earlier versions.
  if (parts.size() != 4 || !is_hex(parts[0]) || !is_number(parts[1]) || !is_hex(parts[2]) || !is_number(parts[3]))
    return std::nullopt;
  return Writer{parts[0], static_cast<pid_t>(std::stol(parts[1])), parts[2]};
}

std::optional<Writer> writer_of(const fs::path& temporary) {
  const std::string name = temporary.filename().string();
  if (!name.starts_with('.')) return std::nullopt;
  for (std::size_t at = name.find(kTemporary); at != std::string::npos; at = name.find(kTemporary, at + 1)) {
    const std::string rest = name.substr(at + kTemporary.size());
    if (const std::optional<Writer> writer = parse_writer(rest.substr(0, rest.find('.')))) return writer;
  }
  return std::nullopt;
}

/// Both times are the file system's, whatever the clocks of the machines say.
bool is_long_unwritten(const fs::path& file) {
  std::error_code error;
  const fs::file_time_type written = fs::last_write_time(file, error);
  if (error) return false;
  const fs::file_time_type latest =
      fs::last_write_time(file.has_parent_path() ? file.parent_path() : fs::path("."), error);
  return !error && latest - written > kLongUnwritten;
}

/// A temporary file whose writer was killed.
bool is_abandoned(const fs::path& temporary) {
  const std::optional<Writer> writer = writer_of(temporary);
  if (!writer) return false;
  const Writer self = this_writer();
  if (writer->machine != self.machine) return is_long_unwritten(temporary);
  if (writer->pid == self.pid) return writer->process != self.process;
  return writer->pid > 0 && ::kill(writer->pid, 0) != 0 && errno == ESRCH;
}

void remove_abandoned_files(const fs::path& folder, const std::function<bool(const fs::path&)>& is_one) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (is_one(it->path()) && is_abandoned(it->path())) fs::remove_all(it->path(), ignored);
  }
}

/// Removes temporary files for the same path whose writers were killed.
void remove_leftovers(const fs::path& folder, const fs::path& path) {
  const std::string stem = temporary_stem(path);
  const std::string extension = path.extension().string();
  remove_abandoned_files(folder, [&](const fs::path& p) {
    const std::string name = p.filename().string();
    return name.starts_with(stem) && name.ends_with(extension);
  });
}

/// The temporary files and folders of this process. Never destroyed: a thread may still write when the process ends.
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

/// Removes a folder into which threads may be writing: under another name none finds it any more.
void remove_for_good(const fs::path& folder) {
  const std::string name = folder.filename().string();
  const fs::path away =
      folder_of(folder) / (name.substr(0, name.rfind(kTemporary)) + std::string(kTemporary) + new_writer_text());
  std::error_code error;
  fs::rename(folder, away, error);
  fs::remove_all(error ? folder : away, error);
}

/// For the rest of this process, so that a thread cannot begin a file that was removed just before.
void open_no_more_files() {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = 0;
  ::setrlimit(RLIMIT_NOFILE, &files);
}

/// A file that a thread is opening at this moment is there after it.
constexpr std::chrono::milliseconds kLongestOpen{5};

}  // namespace

std::string machine_start() { return first_line("/proc/sys/kernel/random/boot_id"); }

void require_file_place(const fs::path& path) {
  const fs::path folder = folder_of(path);
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw CannotComplete(path.string() + ": cannot be written; the folder " + folder.string() + " does not exist");
  }
  if (fs::is_directory(path, error)) throw CannotComplete(path.string() + ": cannot be written; it is a folder");
  if (fs::exists(path, error) && !fs::is_regular_file(path, error)) {
    throw CannotComplete(path.string() + ": cannot be written; it is no regular file");
  }
}

AtomicFile::AtomicFile(fs::path path) : path_(std::move(path)) {
  check_may_write(path_);
  require_file_place(path_);
  const fs::path folder = folder_of(path_);
  remove_leftovers(folder, path_);
  temporary_ = folder / (temporary_stem(path_) + new_writer_text() + path_.extension().string());
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
  require_unchanged_inputs_of_step();
  std::error_code error;
  fs::rename(temporary_, path_, error);
  if (error) throw CannotComplete(path_.string() + ": cannot be written; " + error.message());
  is_finished_ = true;
  forget(temporary_);
  forget_input(path_);
}

void abandon_atomic_files() {
  unfinished().mutex.lock();  // For good.
  std::error_code error;
  for (const fs::path& path : unfinished().paths) {
    if (fs::is_directory(path, error)) remove_for_good(path);
  }
  open_no_more_files();
  std::vector<fs::path> not_there;
  for (const fs::path& path : unfinished().paths) {
    if (!fs::remove(path, error)) not_there.push_back(path);
  }
  if (not_there.empty()) return;
  std::this_thread::sleep_for(kLongestOpen);
  for (const fs::path& path : not_there) fs::remove(path, error);
}

TemporaryFolder::TemporaryFolder(const fs::path& parent, std::string_view stem) {
  const std::string begin = "." + std::string(stem) + std::string(kTemporary);
  remove_abandoned_files(parent, [&](const fs::path& p) { return p.filename().string().starts_with(begin); });
  path_ = parent / (begin + new_writer_text());
  const std::lock_guard lock(unfinished().mutex);
  std::error_code error;
  fs::create_directory(path_, error);
  if (error) throw CannotComplete(path_.string() + ": cannot be made; " + error.message());
  unfinished().paths.insert(path_);
}

TemporaryFolder::~TemporaryFolder() {
  if (is_moved_) return;
  std::error_code error;
  fs::remove_all(path_, error);
  const std::lock_guard lock(unfinished().mutex);
  forget(path_);
}

bool TemporaryFolder::move_to(const fs::path& place) {
  const std::lock_guard lock(unfinished().mutex);
  if (::rename(path_.c_str(), place.c_str()) != 0) {
    const int problem = errno;
    std::error_code error;
    // A network file system may say that it is gone when the rename was done and its answer was lost.
    const bool is_there = fs::is_directory(place, error);
    if (is_there && fs::exists(path_, error)) return false;
    if (!is_there) throw CannotComplete(place.string() + ": cannot be made; " + std::strerror(problem));
  }
  is_moved_ = true;
  forget(path_);
  return true;
}

bool is_temporary(const fs::path& path) { return writer_of(path).has_value(); }

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
    if (!out)
      throw CannotComplete(path.string() + ": cannot be written; is the folder writable and the disk not full?");
  });
}

}  // namespace patinate
