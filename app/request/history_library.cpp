#include "app/request/history_library.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <system_error>

#include "libcommon/core/programs.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"

namespace patinate::app {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kLibraryPrefix = "library:";

}  // namespace

std::vector<fs::path> library_folders() {
  std::vector<fs::path> folders;
  const char* given = std::getenv("PATINATE_LIBRARY");
  if (given != nullptr) {
    for (const std::string& folder : split(given, ':')) {
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  const fs::path programs = programs_folder();
  if (!programs.empty()) folders.push_back((programs / PATINATE_LIBRARY_FROM_PROGRAMS).lexically_normal());
  return folders;
}

std::vector<LibraryEntry> library_entries() {
  std::map<std::string, fs::path> found;
  for (const fs::path& folder : library_folders()) {
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      std::error_code ignored;
      if (fs::is_regular_file(it->path() / kHistoryManifestFile, ignored))
        found.try_emplace(it->path().filename().string(), it->path());
    }
  }
  std::vector<LibraryEntry> entries;
  for (const auto& [name, folder] : found) entries.push_back({name, folder});
  return entries;
}

std::string missing_library_text() {
  return "there is no library of histories; install the package patinate-library, or run tools/library/build in "
         "patinate's source; $PATINATE_LIBRARY names folders that hold histories";
}

std::optional<std::string> library_name(const fs::path& folder) {
  std::error_code error;
  for (const LibraryEntry& entry : library_entries()) {
    if (fs::equivalent(entry.folder, folder, error)) return std::string(kLibraryPrefix) + entry.name;
  }
  return std::nullopt;
}

fs::path library_place(const fs::path& path) {
  const std::string text = path.string();
  if (!text.starts_with(kLibraryPrefix)) return path;
  const std::string name = text.substr(kLibraryPrefix.size());
  const std::vector<LibraryEntry> entries = library_entries();
  std::vector<std::string> names;
  std::string list;
  for (const LibraryEntry& entry : entries) {
    if (entry.name == name) return entry.folder;
    names.push_back(entry.name);
    list += (list.empty() ? "" : ", ") + entry.name;
  }
  if (entries.empty()) throw IoError(text, missing_library_text());
  throw IoError(text, "is not in the library; there is " + list + did_you_mean(name, names));
}

}  // namespace patinate::app
