#include "libcommon/core/read_limit.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

using Folders = std::shared_ptr<const std::vector<fs::path>>;

struct Limit {
  std::mutex mutex;
  Folders folders;
};

Limit& reading() {
  static Limit the_limit;
  return the_limit;
}

Limit& writing() {
  static Limit the_limit;
  return the_limit;
}

Folders folders_now(Limit& limit) {
  const std::scoped_lock lock(limit.mutex);
  return limit.folders;
}

/// Both canonical.
bool lies_below(const fs::path& path, const fs::path& folder) {
  const auto [at_folder, at_path] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return at_folder == folder.end();
}

bool is_allowed(const fs::path& path, const std::vector<fs::path>& folders) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  const fs::path real = error ? fs::path() : fs::weakly_canonical(absolute, error);
  if (error || real.empty()) return false;  // a ring of links, or a folder that may not be looked into
  return std::any_of(folders.begin(), folders.end(), [&](const fs::path& folder) { return lies_below(real, folder); });
}

void set_folders(Limit& limit, const std::vector<fs::path>& folders) {
  std::vector<fs::path> real;
  for (const fs::path& folder : folders) {
    std::error_code error;
    real.push_back(fs::canonical(folder, error));
    if (error || !fs::is_directory(real.back(), error))
      throw IoError(folder.string(), "is no folder; give one that may be read");
  }
  const std::scoped_lock lock(limit.mutex);
  limit.folders = std::make_shared<const std::vector<fs::path>>(std::move(real));
}

void forget_folders(Limit& limit) {
  const std::scoped_lock lock(limit.mutex);
  limit.folders.reset();
}

}  // namespace

ReadLimit::ReadLimit(const std::vector<fs::path>& folders) { set_folders(reading(), folders); }
ReadLimit::~ReadLimit() { forget_folders(reading()); }
WriteLimit::WriteLimit(const std::vector<fs::path>& folders) { set_folders(writing(), folders); }
WriteLimit::~WriteLimit() { forget_folders(writing()); }

bool may_read(const fs::path& path) {
  const Folders folders = folders_now(reading());
  return !folders || is_allowed(path, *folders);
}

void check_may_read(const fs::path& path) {
  const Folders folders = folders_now(reading());
  if (!folders || is_allowed(path, *folders)) return;
  throw IoError(path.string(),
                "lies outside of " + folders->front().string() +
                    ", so it is not shown; serve a folder that holds both, or allow its folder with --allow-folder");
}

void check_may_write(const fs::path& path) {
  const Folders folders = folders_now(writing());
  if (!folders || is_allowed(path.has_parent_path() ? path.parent_path() : fs::path("."), *folders)) return;
  throw CannotComplete(path.string() + ": lies outside of " + folders->front().string() +
                       ", so nothing is written there");
}

}  // namespace patinate
