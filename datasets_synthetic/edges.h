/// \file
/// A card of patches, each of which is a course of color over time that is easily got wrong, photographed at uneven
/// times.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "libcommon/job/job.h"
#include "patinate/core/options.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// Settings of the card.
struct EdgesOptions {
  int patch_px = 32;      ///< Side of a patch; [16, 512]. Between patches and around them is a third of that.
  double noise = 0.0;     ///< Standard deviation of photographs, in 8-bit sRGB codes / 255; [0, 0.5].
  std::int64_t seed = 1;  ///< >= 0.
};
void describe(OptionVisitor& v, EdgesOptions& o);

/// When it is photographed, h: minutes, hours and days apart.
inline constexpr std::array<double, 12> kEdgeTimes{0.0, 0.01, 0.02, 0.5, 1.0, 1.5, 10.0, 11.0, 12.0, 50.0, 99.0, 100.0};

struct EdgePatch {
  std::string_view name;
  std::string_view what;  ///< For people.
};
inline constexpr int kEdgeColumns = 4;
/// In rows of kEdgeColumns.
inline constexpr std::array<EdgePatch, 16> kEdgePatches{
    {{"constant", "gray that never changes"},
     {"black", "no light at all"},
     {"white", "saturated in every photograph"},
     {"red_saturated", "red is saturated, green falls evenly"},
     {"step", "changes at once between 1.5 and 10 h"},
     {"step_first", "changes at once between the first two photographs"},
     {"step_last", "changes at once between the last two photographs"},
     {"even", "changes evenly over all of the time"},
     {"soon", "changes soon: 1 - exp(-t / 0.3 h)"},
     {"late", "changes late: nothing until 50 h, then evenly"},
     {"wiped", "changes evenly until 50 h and back"},
     {"to_and_fro", "changes and back from photograph to photograph"},
     {"faint", "changes by half a code of 8 bits"},
     {"chessboard", "pixels of a chess board, one half changes as the other changes back"},
     {"line", "only a line of one pixel changes"},
     {"spoilt_once", "a highlight in the photograph at 11 h, else gray"}}};

/// Pixels of the card along both sides.
[[nodiscard]] int edges_side(const EdgesOptions& o);
/// Number of the patch at a pixel, -1 between them.
[[nodiscard]] int edge_patch_at(const EdgesOptions& o, int x, int y);
/// Share of a patch's change that has happened at a photograph, [0, 1].
[[nodiscard]] double edge_course(int patch, int frame);
/// Linear color of a pixel at a photograph, without noise.
[[nodiscard]] Vec3 edge_color(const EdgesOptions& o, int x, int y, int frame);

/// Plan that writes, into `output`: `capture.json` (times as a list), `frames/0000.png ...`, `mask.png` (a corner of
/// the card is not to be looked at) - what a lab would have; and `truth/albedo/0000.exr ...`, `truth/patches.exr`
/// (number, -1 between patches) and `truth/truth.json` (options, patches, times and `"key"`; the plan's manifest).
/// @throws InvalidInput if an option is out of range.
[[nodiscard]] JobPlan plan_edges(const EdgesOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
