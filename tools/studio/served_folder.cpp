#include "tools/studio/served_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "libcommon/job/result_folder.h"
#include "patinate/core/error.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

/// Whether a name may be put behind a folder's path at all.
bool is_plain(std::string_view name) {
  if (name.find('\0') != std::string_view::npos || name.find('\\') != std::string_view::npos) return false;
  const fs::path path{std::string(name)};
  return path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

/// Both canonical.
bool lies_below(const fs::path& path, const fs::path& folder) {
  const auto [at_folder, at_path] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return at_folder == folder.end();
}

std::optional<fs::path> existing_below(const fs::path& folder, std::string_view name) {
  if (!is_plain(name)) return std::nullopt;
  std::error_code error;
  const fs::path path = fs::canonical(folder / fs::path(std::string(name)), error);
  if (error || !lies_below(path, folder)) return std::nullopt;
  return path;
}

}  // namespace

ServedFolder::ServedFolder(const fs::path& folder) {
  std::error_code error;
  root_ = fs::canonical(folder, error);
  if (error || !fs::is_directory(root_, error))
    throw IoError(folder.string(), "is no folder; give one that holds histories, transfers, simulations or scenes");
}

std::optional<fs::path> ServedFolder::find(std::string_view name) const {
  std::optional<fs::path> path = existing_below(root_, name.empty() ? "." : name);
  return path;
}

std::optional<fs::path> ServedFolder::find_below(const fs::path& place, std::string_view name) const {
  std::error_code error;
  const fs::path folder = fs::is_directory(place, error) ? place : place.parent_path();
  if (!lies_below(folder, root_)) return std::nullopt;
  return existing_below(folder, name);
}

fs::path ServedFolder::writable_path(std::string_view name) const {
  const std::string shown(name);
  const fs::path path{shown};
  if (!is_plain(name) || !path.has_filename() || path.filename() == ".")
    throw InvalidInput("\"" + shown + "\" is no name below the folder; give one such as results/rust.json");
  const std::optional<fs::path> folder = find(path.parent_path().string());
  std::error_code error;
  if (!folder || !fs::is_directory(*folder, error))
    throw InvalidInput("the folder of \"" + shown + "\" does not exist; make it first");
  if (const fs::path result = result_around(*folder); !result.empty()) {
    throw InvalidInput("\"" + shown + "\" would lie in " +
                       (result == root_ ? "the folder that is served, which is" : name_of(result) + ", which is") +
                       " a finished result and stays as it was made; give a name outside of it");
  }
  return *folder / path.filename();
}

fs::path ServedFolder::new_path(std::string_view name) const {
  fs::path made = writable_path(name);
  std::error_code error;
  if (fs::symlink_status(made, error).type() != fs::file_type::not_found)
    throw InvalidInput("\"" + std::string(name) + "\" exists; give another name");
  return made;
}

fs::path ServedFolder::make_file(std::string_view folder, const std::string& stem, const std::string& extension) const {
  constexpr int kMaxOfOneName = 1000;
  for (int k = 1; k <= kMaxOfOneName; ++k) {
    const std::string name = stem + (k == 1 ? std::string() : "-" + std::to_string(k)) + extension;
    fs::path path = writable_path((fs::path(std::string(folder)) / name).generic_string());
    const int file = ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (file >= 0) {
      ::close(file);
      return path;
    }
    if (errno != EEXIST) throw CannotComplete(path.string() + ": " + std::generic_category().message(errno));
  }
  throw InvalidInput("there are " + std::to_string(kMaxOfOneName) + " files like \"" + stem + extension +
                     "\"; give another name");
}

std::string ServedFolder::name_of(const fs::path& path) const {
  const std::string name = path.lexically_relative(root_).generic_string();
  return name.empty() ? "." : name;
}

}  // namespace patinate::studio
