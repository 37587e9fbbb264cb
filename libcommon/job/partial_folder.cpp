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
#include <sstream>
#include <system_error>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/temporary_file.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr const char* kBook = ".job";
constexpr const char* kWritten = "written";
constexpr const char* kDiscarded = "discarded";
constexpr unsigned kRenameExchange = 2;  // RENAME_EXCHANGE of <linux/fs.h>

[[noreturn]] void fail(const fs::path& path, const std::string& what, int error) {
  throw CannotComplete(path.string() + ": " + what + "; " + std::strerror(error));
}

[[noreturn]] void fail_in_use(const fs::path& path) {
  throw CannotComplete(path.string() + ": another process is making this output; wait for it or give another output");
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
  constexpr std::uint64_t kMost = 1 << 20;
  return fs::is_regular_file(path, error) ? read_file(path, kMost) : std::string();
}

/// Mark of an item of this key. What was not forced to the disk is what it seems until the machine starts anew. Empty
/// where nobody can tell.
std::string written_text(const std::string& item_key) {
  const std::string start = machine_start();
  return start.empty() || item_key.empty() ? "" : item_key + "\n" + start + "\n";
}

}  // namespace

void sync_path(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(path, "cannot be written", errno);
  const int error = ::fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  // Some file systems refuse fsync on folders; that costs safety against power cuts only.
  if (error != 0 && error != EINVAL) fail(path, "cannot be written", error);
}

void fail_written(const fs::filesystem_error& error) {
  const fs::path& path = error.path2().empty() ? error.path1() : error.path2();
  throw CannotComplete(path.string() + ": cannot be written; " + error.code().message());
}

std::string marker_text(const DoneItem& done) {
  std::string text = done.key + "\n";
  for (const auto& [file, key] : done.files) text += key + " " + file + "\n";
  return text;
}

DoneItem parse_marker(const std::string& text) {
  std::istringstream lines(text);
  DoneItem done;
  std::getline(lines, done.key);
  std::string line;
  while (std::getline(lines, line)) {
    const std::size_t space = line.find(' ');
    if (space != std::string::npos) done.files[line.substr(space + 1)] = line.substr(0, space);
  }
  return done;
}

DoneItem finish_item(const fs::path& folder, const JobItem& item, const std::string& item_key,
                     const RunControl& control) {
  DoneItem done{item_key, {}};
  const auto add = [&](const fs::path& output) {
    for (const fs::path& written : {folder / output, (folder / output).parent_path()}) {
      control.throw_if_stopped();
      sync_path(written);
    }
    done.files[output.generic_string()] = hash_file(folder / output);
  };
  for (const fs::path& output : item.outputs) {
    if (!fs::exists(folder / output))
      throw CannotComplete((folder / output).string() + ": was not made by its step `" + item.name + "`");
    add(output);
  }
  for (const fs::path& output : item.optional_outputs) {
    if (fs::exists(folder / output)) add(output);
  }
  return done;
}

void link_or_copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (error) fail(to.parent_path(), "cannot be made", error.value());
  fs::remove(to, error);
  fs::create_hard_link(from, to, error);
  if (!error) return;
  write_atomically(to, [&](const fs::path& temporary) { fs::copy_file(from, temporary); });
}

std::string manifest_key(const fs::path& folder, const std::string& manifest) {
  const UnwatchedReads of_output;
  std::error_code error;
  if (!fs::is_regular_file(folder / manifest, error)) return "";
  try {
    const Json json = load_json(folder / manifest);
    if (json.is_object() && json.contains("key") && json["key"].is_string()) return json["key"].get<std::string>();
  } catch (const IoError&) {
    // A damaged manifest is no proof that the folder is ours.
  }
  return "";
}

bool is_work(const fs::path& relative) {
  const fs::path normal = relative.lexically_normal(), work(kJobWorkFolder);
  return std::mismatch(work.begin(), work.end(), normal.begin(), normal.end()).first == work.end();
}

fs::path partial_path(const fs::path& output) { return output.string() + ".partial"; }

DoneItem read_marker(const fs::path& partial, const std::string& item) {
  return parse_marker(read_small(partial / kBook / "done" / item));
}

std::optional<std::vector<fs::path>> finished_files(const fs::path& partial, const JobItem& item,
                                                    const std::string& item_key) {
  const DoneItem done = read_marker(partial, item.name);
  if (done.key != item_key || item_key.empty()) return std::nullopt;
  std::optional<std::vector<fs::path>> files = made_files(item, done);
  const auto is_there = [&](const fs::path& file) {
    std::error_code error;
    if (!fs::exists(partial / file, error)) return false;
    const auto num_links = fs::hard_link_count(partial / file, error);
    return !error && (num_links == 1 || is_unchanged(partial, {file}, done));
  };
  if (files && !std::all_of(files->begin(), files->end(), is_there)) files.reset();
  return files;
}

bool is_partial_whole(const fs::path& partial, const std::string& manifest, const std::string& key) {
  std::error_code error;
  return !fs::exists(partial / kBook / "key", error) && manifest_key(partial, manifest) == key;
}

PartialFolder::PartialFolder(const fs::path& output, std::string manifest)
    : output_(output), path_(partial_path(output)), manifest_(std::move(manifest)) {
  check_may_write(path_ / kBook / "lock");  // Both folders may be links.
  lock();
  try {
    const bool is_ours = fs::exists(path_ / kBook) || fs::is_empty(path_) || !manifest_key(path_, manifest_).empty();
    if (!is_ours) {
      throw CannotComplete(path_.string() +
                           ": holds files that patinate did not write; move them or give another output");
    }
    lock_for_other_machines();
  } catch (...) {
    ::close(fd_);
    throw;
  }
}

PartialFolder::~PartialFolder() {
  if (file_fd_ >= 0) ::close(file_fd_);
  ::close(fd_);
}

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
      if (error == EWOULDBLOCK) fail_in_use(path_);
      fail(path_, "cannot be locked", error);
    }
    struct stat opened {
    }, named{};
    if (::fstat(fd_, &opened) == 0 && ::stat(path_.c_str(), &named) == 0 && opened.st_ino == named.st_ino) return;
    ::close(fd_);  // we locked a folder that has another name by now
  }
}

void PartialFolder::lock_for_other_machines() {
  const fs::path file = path_ / kBook / "lock";
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  file_fd_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_fd_ < 0) fail(file, "cannot be written", errno);
  if (::flock(file_fd_, LOCK_EX | LOCK_NB) == 0) return;
  const bool is_in_use = errno == EWOULDBLOCK;  // Else this file system has no such locks.
  ::close(std::exchange(file_fd_, -1));
  if (is_in_use) fail_in_use(path_);
}

bool PartialFolder::begin(const std::string& key) {
  if (read_small(path_ / kBook / "key") == key) return true;
  make_file(path_ / kBook / "key", key);
  return false;
}

void PartialFolder::mark_unfinished() {
  if (!fs::exists(path_ / kBook / "key")) make_file(path_ / kBook / "key", kDiscarded);
}

bool PartialFolder::has_done_items() const {
  const auto has_files = [this](const char* folder) {
    std::error_code error;
    return fs::directory_iterator(path_ / kBook / folder, error) != fs::directory_iterator();
  };
  return has_files("done") || has_files(kWritten);
}

void PartialFolder::mark_written(const JobItem& item, const std::string& item_key) {
  const std::string text = written_text(item_key);
  if (text.empty()) return;
  std::error_code error;
  fs::create_directories(path_ / kBook / kWritten, error);
  std::ofstream(path_ / kBook / kWritten / item.name) << text;  // Half of it does not count.
}

bool PartialFolder::finish_written(const JobItem& item, const std::string& item_key, const RunControl& control) {
  const fs::path note = path_ / kBook / kWritten / item.name;
  const std::string text = written_text(item_key);
  if (text.empty() || read_small(note) != text || fs::exists(path_ / kBook / "done" / item.name)) return false;
  try {
    mark_done(item, item_key, control);
  } catch (const CannotComplete&) {
    return false;
  }
  return true;
}

void PartialFolder::forget_written() { remove_tree(path_ / kBook / kWritten); }

void PartialFolder::mark_done(const JobItem& item, const std::string& item_key, const RunControl& control) {
  try {
    const std::string marker = marker_text(finish_item(path_, item, item_key, control));
    control.throw_if_stopped();
    make_file(path_ / kBook / "done" / item.name, marker);
  } catch (const CannotComplete&) {
    std::error_code error;
    fs::remove(path_ / kBook / kWritten / item.name,
               error);  // Files that the disk refused are not there, whatever it seems.
    throw;
  }
}

bool PartialFolder::adopt(const fs::path& finished, const JobItem& item, const DoneItem& done) {
  std::error_code error;
  const auto files = made_files(item, done);
  if (!files) return false;
  const std::vector<fs::path>& outputs = *files;
  const auto is_there = [&](const fs::path& p) { return !is_work(p) && fs::is_regular_file(finished / p, error); };
  if (!std::all_of(outputs.begin(), outputs.end(), is_there)) return false;
  for (const fs::path& output : outputs) link_or_copy(finished / output, path_ / output);
  if (!is_unchanged(path_, outputs, done)) {
    for (const fs::path& output : outputs) fs::remove(path_ / output, error);
    return false;
  }
  for (const fs::path& output : outputs) sync_path((path_ / output).parent_path());
  make_file(path_ / kBook / "done" / item.name, marker_text(done));
  return true;
}

void PartialFolder::write_record(JobRecord record, const std::set<std::string>& items, const RunControl& control) {
  for (const std::string& item : items) {
    control.throw_if_stopped();
    DoneItem done = read_marker(path_, item);
    std::erase_if(done.files, [](const auto& file) { return is_work(file.first); });
    if (!done.files.empty()) record.items[item] = std::move(done);
  }
  write_job_record(path_, std::move(record), manifest_);
}

void PartialFolder::keep_only(const std::set<std::string>& items, const std::set<fs::path>& files,
                              const RunControl& control) {
  // Markers first: one that outlived its file would vouch for what another plan leaves half done in its place.
  const fs::path done = path_ / kBook / "done";
  std::vector<fs::path> markers;
  if (fs::exists(done)) {
    for (const auto& entry : fs::directory_iterator(done)) {
      if (!items.contains(entry.path().filename().string())) markers.push_back(entry.path());
    }
  }
  for (const fs::path& p : markers) {
    control.throw_if_stopped();
    remove_tree(p);
  }
  if (!markers.empty()) sync_path(done);

  std::set<fs::path> kept_folders;
  for (const fs::path& file : files) {
    for (fs::path p = file.parent_path(); !p.empty(); p = p.parent_path()) kept_folders.insert(p);
  }
  std::vector<fs::path> unwanted;
  for (auto it = fs::recursive_directory_iterator(path_); it != fs::recursive_directory_iterator(); ++it) {
    control.throw_if_stopped();
    const fs::path relative = it->path().lexically_relative(path_);
    const bool is_folder = it->is_directory() && !it->is_symlink();
    if (relative == kBook || relative == kJobWorkFolder) continue;
    if (relative.parent_path() == kBook) {
      if (is_folder) it.disable_recursion_pending();
    } else if (is_folder ? !kept_folders.contains(relative) : !files.contains(relative)) {
      unwanted.push_back(it->path());
      if (is_folder) it.disable_recursion_pending();
    }
  }
  for (const fs::path& p : unwanted) {
    control.throw_if_stopped();
    remove_tree(p);
  }
}

void PartialFolder::publish(bool replace, const RunControl& control) {
  // The key first: without it the folder is whole, with it a kill before the last marker is gone would lose finished
  // items.
  remove_tree(path_ / kBook / "key");
  std::vector<fs::path> markers;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_ / kBook / "done", error)) markers.push_back(entry.path());
  for (std::size_t i = 0; i < markers.size(); ++i) {
    remove_tree(markers[i]);
    control.report(static_cast<double>(i + 1) / static_cast<double>(markers.size() + 1));  // The rest is quick.
  }
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
  sync_path(folder_of(output_));
  if (replace) discard();
}

void PartialFolder::discard() {
  mark_unfinished();
  keep_only({}, {});
  remove_tree(path_);
}

}  // namespace patinate
