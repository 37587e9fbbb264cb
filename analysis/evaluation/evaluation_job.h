/// \file
/// An evaluation of several coordinate maps as a job: `evaluation.html`, `evaluation.json`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evaluation/evaluation.h"
#include "analysis/evaluation/map_figures.h"
#include "libcommon/job/job.h"

namespace patinate::analysis {

inline constexpr const char* kEvaluationFile = "evaluation.json";
inline constexpr const char* kEvaluationPageFile = "evaluation.html";

/// A map with all that it is measured against.
struct MapToEvaluate {
  SynthesisSource source;
  SynthesizedMap map;
  std::optional<MadePicture> made;
  std::vector<Figure> more;  ///< What its maker knows beside: energy, audit (M1). Shown first.
};

/// What is known of a map of several tiles once all of them were surveyed.
struct OpenedTiles {
  SynthesisSource source;
  MapFacts map;                                                       ///< Its surface finds texels where one looks.
  CoordinateReader coordinates;                                       ///< Called for rectangles inside one tile.
  std::function<ImageF(int tile, const RunControl& control)> wanted;  ///< The control of a tile with its margins.
  /// Whole numbers that more() makes figures of, those of all tiles one after another.
  /// @param before  Covered texels of earlier tiles.
  std::function<std::vector<std::int64_t>(int tile, std::int64_t before, const RunControl& control)> measure_more;
  std::function<std::vector<Figure>(const std::vector<std::int64_t>& all)> more;  ///< MapToEvaluate::more.
};

/// A map of several tiles, of which no process holds more than one.
struct TilesToEvaluate {
  Sheet sheet;
  /// Without figures; finds texels where one looks.
  std::function<std::shared_ptr<TexelMap>(const RunControl& control)> surface;
  std::vector<std::string> survey_files;  ///< Names before ".TILE" of what survey() writes.
  /// Writes files of a tile, for open().
  std::function<void(int tile, const TexelMap& surface, const std::filesystem::path& folder, const RunControl& control)>
      survey;
  /// @param surface  With figures.
  std::function<OpenedTiles(std::shared_ptr<const TexelMap> surface, const std::filesystem::path& folder,
                            const RunControl& control)>
      open;
  std::int64_t source_bytes = 0;  ///< About what the opened source takes.
};

/// One map that is opened when its turn comes.
struct EvaluationItem {
  std::string name;   ///< Unique; for people.
  std::string about;  ///< One line: file, source, control.
  std::string key;    ///< Of all that it depends on.
  std::function<MapToEvaluate(const RunControl& control)> open;
  std::optional<TilesToEvaluate> tiles = {};  ///< Instead of `open`, where there are several.
};

struct EvaluationTask {
  std::vector<EvaluationItem> maps;  ///< At least one.
  EvaluationOptions options;
  std::uint64_t seed = 1;
  std::string command;  ///< What repeats it, for the report; no part of the key.
};

/// An item a map; for maps of several tiles two a tile, which survey and measure it, and one that concludes.
/// @throws InvalidInput if there is no map or a name occurs twice.
[[nodiscard]] JobPlan plan_evaluation(EvaluationTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
