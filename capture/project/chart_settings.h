/// \file
/// What a project says of a color chart in its photographs, and what a command changes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/chart/chart_table.h"
#include "capture/project/frame_sources.h"
#include "patinate/core/json.h"
#include "patinate/core/options.h"

namespace patinate::capture {

struct ChartSettings {
  ChartTable table;  ///< The classic chart, or the project's own.
  /// Outer corners of the outermost patches in every photograph of the chart; nothing where it is looked for.
  std::optional<std::array<Eigen::Vector2d, 4>> corners = {};
  /// Photographs of the chart alone, one for each frame; empty where the frames themselves show it.
  std::vector<CapturePhoto> photos = {};
  bool interpolates = false;  ///< A photograph whose chart cannot be used takes its light from those before and after.
};

/// Settings that the command line gives instead of the project.
struct ChartOptions {
  enum class Method { Project, Off, Auto } method = Method::Project;
};
void describe(OptionVisitor& v, ChartOptions& o);

/// Member `chart` of a project, then the option over it.
/// @param num_images  That the project lists, excluded ones too. @param frames  Those that are left.
/// @throws IoError
[[nodiscard]] std::optional<ChartSettings> read_chart_settings(JsonReader& project, const ChartOptions& options,
                                                               int num_images, const std::vector<CapturePhoto>& frames);

}  // namespace patinate::capture
