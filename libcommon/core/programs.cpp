#include "libcommon/core/programs.h"

#include <mutex>

namespace patinate {

namespace fs = std::filesystem;

namespace {

struct Folder {
  std::mutex mutex;
  fs::path path;
};

Folder& folder() {
  static Folder kept;
  static const bool is_found = [] {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (!error) kept.path = program.parent_path();
    return true;
  }();
  (void)is_found;
  return kept;
}

}  // namespace

fs::path programs_folder() {
  Folder& kept = folder();
  const std::lock_guard lock(kept.mutex);
  return kept.path;
}

void set_programs_folder(const fs::path& path) {
  Folder& kept = folder();
  const std::lock_guard lock(kept.mutex);
  kept.path = path;
}

}  // namespace patinate
