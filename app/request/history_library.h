/// \file
/// Histories to start from: `library:NAME` wherever a command takes a history.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace patinate::app {

struct LibraryEntry {
  std::string name;
  std::filesystem::path folder;
};

/// Where histories are looked for: those of $PATINATE_LIBRARY (separated by `:`), then the one installed with the
/// program. They need not exist.
[[nodiscard]] std::vector<std::filesystem::path> library_folders();
/// Folders in those that hold a `history.json`, by name; the first of a name counts.
[[nodiscard]] std::vector<LibraryEntry> library_entries();
/// Where no library is, what makes one.
[[nodiscard]] std::string missing_library_text();

/// `library:NAME` for a folder that it stands for; nothing for others.
[[nodiscard]] std::optional<std::string> library_name(const std::filesystem::path& folder);
/// The folder that `library:NAME` stands for; other paths as they are. @throws IoError listing what there is.
[[nodiscard]] std::filesystem::path library_place(const std::filesystem::path& path);

}  // namespace patinate::app
