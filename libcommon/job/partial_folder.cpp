#include "libcommon/job/partial_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "libcommon/core/error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/json.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr const char* kBook = ".job";
constexpr const char* kDiscarded = "discarded";
constexpr unsigned kRenameExchange = 2;  // RENAME_EXCHANGE of <linux/fs.h>

[[noreturn]] void fail(const fs::path& path, const std::string& what, int error) {
  throw CannotComplete(path.string() + ": " + what + "; " + std::strerror(error));
}

void sync_path(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(path, "cannot be written", errno);
  const int error = ::fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  // Some file systems refuse fsync on folders; that costs safety against power cuts only.
  if (error != 0 && error != EINVAL) fail(path, "cannot be written", error);
}

void make_file(const fs::path& path, const std::string& text) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) fail(path.parent_path(), "cannot be made", error.value());
  write_atomically(path, text);
}

void remove_tree(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) fail(path, "cannot be removed", error.value());
}

std::string read_small(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) ? read_file(path, 4096) : std::string();
}

}  // namespace

std::string manifest_key(const fs::path& folder, const std::string& manifest) {
  std::error_code error;
  if (!fs::is_regular_file(folder / manifest, error)) return "";
  try {
    const Json json = load_json(folder / manifest);
    if (json.is_object() && json.contains("key") && json["key"].is_string()) return json["key"].get<std::string>();
  } catch (const InvalidInput&) {
    // A damaged manifest is no proof that the folder is ours.
  }
  return "";
}

PartialFolder::PartialFolder(const fs::path& output, std::string manifest)
    : output_(output), path_(output.string() + ".partial"), manifest_(std::move(manifest)) {
  lock();
  try {
    const bool is_ours = fs::exists(path_ / kBook) || fs::is_empty(path_) || !manifest_key(path_, manifest_).empty();
    if (!is_ours) {
      throw CannotComplete(path_.string() + ": holds files that patinate did not write; move them or give another output");
    }
  } catch (...) {
    ::close(fd_);
    throw;
  }
}

PartialFolder::~PartialFolder() { ::close(fd_); }

void PartialFolder::lock() {
  while (true) {
    if (::mkdir(path_.c_str(), 0777) != 0 && errno != EEXIST) fail(path_, "cannot be made", errno);
    fd_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd_ < 0) {
      if (errno == ENOENT) continue;  // renamed by a run that has just finished
      fail(path_, "cannot be opened", errno);
    }
    if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      ::close(fd_);
      if (error == EWOULDBLOCK) {
        throw CannotComplete(path_.string() + ": another process is making this output; wait for it or give another output");
      }
      fail(path_, "cannot be locked", error);
    }
    struct stat opened {}, named {};
    if (::fstat(fd_, &opened) == 0 && ::stat(path_.c_str(), &named) == 0 && opened.st_ino == named.st_ino) return;
    ::close(fd_);  // we locked a folder that has another name by now
  }
}

bool PartialFolder::is_whole(const std::string& key) const {
  return !fs::exists(path_ / kBook / "key") && manifest_key(path_, manifest_) == key;
}

void PartialFolder::begin(const std::string& key) {
  if (read_small(path_ / kBook / "key") != key) make_file(path_ / kBook / "key", key);
}

void PartialFolder::mark_unfinished() {
  if (!fs::exists(path_ / kBook / "key")) make_file(path_ / kBook / "key", kDiscarded);
}

bool PartialFolder::is_done(const std::string& item, const std::string& item_key) const {
  const fs::path marker = path_ / kBook / "done" / item;
  std::error_code error;
  return fs::exists(marker, error) && read_small(marker) == item_key;
}

bool PartialFolder::has_done_items() const {
  std::error_code error;
  return fs::directory_iterator(path_ / kBook / "done", error) != fs::directory_iterator();
}

void PartialFolder::mark_done(const std::string& item, const std::string& item_key,
                              const std::vector<fs::path>& outputs) {
  for (const fs::path& output : outputs) {
    if (!fs::exists(path_ / output)) throw CannotComplete((path_ / output).string() + ": was not made by its step");
    sync_path(path_ / output);
    sync_path((path_ / output).parent_path());
  }
  make_file(path_ / kBook / "done" / item, item_key);
}

void PartialFolder::keep_only(const std::set<std::string>& items, const std::set<fs::path>& files) {
  // Markers first: one that outlived its file would vouch for what another plan leaves half done in its place.
  const fs::path done = path_ / kBook / "done";
  std::vector<fs::path> markers;
  if (fs::exists(done)) {
    for (const auto& entry : fs::directory_iterator(done)) {
      if (!items.contains(entry.path().filename().string())) markers.push_back(entry.path());
    }
  }
  for (const fs::path& p : markers) remove_tree(p);
  if (!markers.empty()) sync_path(done);

  std::set<fs::path> kept_folders;
  for (const fs::path& file : files) {
    for (fs::path p = file.parent_path(); !p.empty(); p = p.parent_path()) kept_folders.insert(p);
  }
  std::vector<fs::path> unwanted;
  for (auto it = fs::recursive_directory_iterator(path_); it != fs::recursive_directory_iterator(); ++it) {
    const fs::path relative = it->path().lexically_relative(path_);
    const bool is_folder = it->is_directory() && !it->is_symlink();
    if (relative == kBook) {
      it.disable_recursion_pending();
    } else if (is_folder ? !kept_folders.contains(relative) : !files.contains(relative)) {
      unwanted.push_back(it->path());
      if (is_folder) it.disable_recursion_pending();
    }
  }
  for (const fs::path& p : unwanted) remove_tree(p);
}

void PartialFolder::publish(bool replace) {
  remove_tree(path_ / kBook / "done");
  remove_tree(path_ / kBook);
  sync_path(path_);
  if (!replace) {
    if (::rename(path_.c_str(), output_.c_str()) != 0) fail(output_, "cannot be made", errno);
  } else if (::syscall(SYS_renameat2, AT_FDCWD, path_.c_str(), AT_FDCWD, output_.c_str(), kRenameExchange) != 0) {
    if (errno != ENOSYS && errno != EINVAL) fail(output_, "cannot be replaced", errno);
    // This file system cannot exchange folders: a moment without OUT.
    const fs::path old = output_.string() + ".old.partial";
    remove_tree(old);
    if (::rename(output_.c_str(), old.c_str()) != 0) fail(output_, "cannot be replaced", errno);
    if (::rename(path_.c_str(), output_.c_str()) != 0) fail(output_, "cannot be made", errno);
    if (::rename(old.c_str(), path_.c_str()) != 0) fail(old, "cannot be renamed", errno);
  }
  sync_path(output_.has_parent_path() ? output_.parent_path() : fs::path("."));
  if (replace) discard();
}

void PartialFolder::discard() {
  mark_unfinished();
  keep_only({}, {});
  remove_tree(path_);
}

}  // namespace patinate
