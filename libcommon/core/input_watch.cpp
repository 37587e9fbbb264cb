#include "libcommon/core/input_watch.h"

#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <vector>

#include "libcommon/core/temporary_file.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// Facts that tell one content of a file from another without reading it.
struct FileState {
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = 0;
  time_t seconds = 0;
  long nanoseconds = 0;
  bool operator==(const FileState& other) const {
    return std::tie(device, inode, size, seconds, nanoseconds) ==
           std::tie(other.device, other.inode, other.size, other.seconds, other.nanoseconds);
  }
};

struct Noted {
  fs::path shown;  ///< Shown as it was first named.
  FileState state;
  bool is_forgotten = false;
};

constexpr std::size_t kNoLook = std::numeric_limits<std::size_t>::max();

struct Notes {
  std::mutex mutex;
  std::atomic<bool> is_watching{false};
  std::atomic<std::size_t> step_begin{0};
  std::map<std::string, Noted> files;  ///< By absolute path; entries stay where they are.
  std::vector<const Noted*> opened;    ///< In order.
};
Notes& notes() {
  static Notes all;
  return all;
}

thread_local int num_unwatched = 0;

FileState state_of(const fs::path& path) {
  struct stat s {};
  if (::stat(path.c_str(), &s) != 0) return {};
  return {s.st_dev, s.st_ino, s.st_size, s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
}

/// Work in progress and kept earlier work may be replaced by others at any time by the same.
bool is_of_work(const fs::path& path) {
  return std::any_of(path.begin(), path.end(), [](const fs::path& part) {
    return part == ".cache" || part.extension() == ".partial" || part.extension() == ".items" || is_temporary(part);
  });
}

std::string name_of(const fs::path& path) {
  std::error_code error;
  return fs::absolute(path, error).lexically_normal().string();
}

}  // namespace

InputChanged::InputChanged(const fs::path& path)
    : IoError(path.string(), "was changed while it was read; run the command again when nothing writes it") {}

InputWatch::InputWatch() { notes().is_watching = true; }
InputWatch::~InputWatch() {
  const std::lock_guard lock(notes().mutex);
  notes().is_watching = false;
  notes().opened.clear();
  notes().files.clear();
}

UnwatchedReads::UnwatchedReads() { ++num_unwatched; }
UnwatchedReads::~UnwatchedReads() { --num_unwatched; }

void note_input(const fs::path& path) {
  if (!notes().is_watching || num_unwatched > 0) return;
  const std::string name = name_of(path);
  if (is_of_work(name) || name.starts_with("/dev/") || name.starts_with("/proc/")) return;
  const FileState now = state_of(path);
  const std::lock_guard lock(notes().mutex);
  const auto [at, is_new] = notes().files.try_emplace(name, Noted{path, now});
  Noted& noted = at->second;
  if (noted.is_forgotten) noted = {path, now};
  if (!(noted.state == now)) throw InputChanged(noted.shown);
  notes().opened.push_back(&noted);
}

std::size_t num_input_notes() {
  const std::lock_guard lock(notes().mutex);
  return notes().opened.size();
}

void require_unchanged_inputs(std::size_t since) {
  if (!notes().is_watching) return;
  std::vector<Noted> files;
  {
    const std::lock_guard lock(notes().mutex);
    const std::size_t begin = std::min(since, notes().opened.size());
    std::vector<const Noted*> all(notes().opened.begin() + static_cast<std::ptrdiff_t>(begin), notes().opened.end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    for (const Noted* noted : all) files.push_back(*noted);
  }
  for (const Noted& noted : files) {
    if (!noted.is_forgotten && !(state_of(noted.shown) == noted.state)) throw InputChanged(noted.shown);
  }
}

bool is_noted_input(const fs::path& path) {
  const FileState state = state_of(path);
  if (state.inode == 0) return false;
  const std::lock_guard lock(notes().mutex);
  return std::any_of(notes().files.begin(), notes().files.end(), [&](const auto& file) {
    const Noted& noted = file.second;
    return !noted.is_forgotten && noted.state.device == state.device && noted.state.inode == state.inode;
  });
}

void forget_input(const fs::path& path) {
  if (!notes().is_watching) return;
  const std::lock_guard lock(notes().mutex);
  const auto at = notes().files.find(name_of(path));
  if (at != notes().files.end()) at->second.is_forgotten = true;
}

InputStep::InputStep(Look look)
    : before_(notes().step_begin.exchange(look == Look::None ? kNoLook : num_input_notes())) {}
InputStep::~InputStep() { notes().step_begin = before_; }

void require_unchanged_inputs_of_step() {
  const std::size_t begin = notes().step_begin;
  if (begin != kNoLook) require_unchanged_inputs(begin);
}

}  // namespace patinate
