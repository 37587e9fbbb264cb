/// \file
/// What a library is made of: the member `library` of its history.json. Everything but transfers sees one history.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/history/history.h"

namespace patinate {

/// One of several histories that lie side by side in one: a library (`patinate combine`).
struct LibraryPart {
  std::string name;
  int x = 0;           ///< Its first column; its first row is 0.
  int width = 0;
  int height = 0;
  std::string key;     ///< Content key of the history that it was made from.
};
/// The control of a library that says which part a pixel belongs to: its physical value is the part's index.
inline constexpr const char* kLibraryControl = "history";
inline constexpr const char* kLibraryControlUnit = "index";
inline constexpr int kMaxLibraryParts = 64;

/// From left to right, apart from each other; empty: the history is no library. @throws IoError if they break the format or do not fit.
[[nodiscard]] std::vector<LibraryPart> library_parts(const HistoryReader& history);

/// As write_history_manifest(), with its parts. @throws InvalidInput also if they do not fit, or kLibraryControl is missing.
void write_library_manifest(const std::filesystem::path& file, const HistoryManifest& manifest, const std::vector<LibraryPart>& parts);

}  // namespace patinate
