/// \file
/// What the studio can show: folders and files that patinate made or reads.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/studio/served_folder.h"

namespace patinate::studio {

enum class PlaceKind { History, Transfer, Simulation, Scene, Ingest, Registration, Unlit, Calibration, Mesh, Report };
inline constexpr std::array<std::string_view, 10> kPlaceKindNames{
    "history", "transfer", "simulation", "scene", "ingest", "registration", "unlit", "calibration", "mesh", "report"};

/// Whether LiveScenes opens it.
[[nodiscard]] inline bool can_run(PlaceKind kind) { return kind == PlaceKind::Scene || kind == PlaceKind::Simulation; }
inline constexpr const char* kOnlyScenesRun = "only scenes and simulations run";

/// A folder by the manifest in it, a file by its extension and "format"; its content is not checked. Nothing if it is
/// none of these.
[[nodiscard]] std::optional<PlaceKind> place_kind(const std::filesystem::path& path);

struct PlaceEntry {
  std::string place;  ///< Its name below the served folder; "." for that itself.
  PlaceKind kind = PlaceKind::History;
  std::string name;      ///< For people.
  std::string detail;    ///< One short line: "12 frames, 512 x 512, 0-26 d".
  std::string problem;   ///< Why it cannot be opened; "" when it seems right.
  std::string modified;  ///< "2026-11-21T15:04:05Z".
};

/// All places, sorted by name. Looks five folders deep, at 20,000 files and folders at most; not into hidden ones,
/// unfinished ones
/// (`.partial`), nor into the folders of places, but for captures and reports.
[[nodiscard]] std::vector<PlaceEntry> list_places(const ServedFolder& folder);
/// When a file was written last, "2026-11-21T15:04:05Z"; "" if it is not there.
[[nodiscard]] std::string modified_text(const std::filesystem::path& path);
/// @param path  Inside the folder, of a kind.
[[nodiscard]] PlaceEntry describe_place(const ServedFolder& folder, const std::filesystem::path& path, PlaceKind kind);

}  // namespace patinate::studio
