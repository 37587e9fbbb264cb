/// \file
/// What a color chart shows: names, places and colors of its patches.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace patinate::capture {

/// Fewest patches of a table: with three numbers each, more than twice as many as a photograph and its camera take.
inline constexpr std::size_t kMinPatches = 12;

struct ChartPatch {
  std::string name;
  double x = 0.0;  ///< Its middle across the chart: 0 and 1 are the outer edges of the outermost patches.
  double y = 0.0;
  std::array<double, 3> lab{};     ///< CIE L*a*b* under D65, 2 degrees.
  std::array<double, 3> linear{};  ///< The color as linear Rec. 709; negative where that has no such color.
};

/// Upper left (dark skin) first, row by row.
using ChartTable = std::vector<ChartPatch>;

/// Published values of the classic chart of 24 patches: pigments changed in November 2014.
enum class ChartEdition { Since2014, Before2014 };
/// White that a table's L*a*b* are relative to.
enum class ChartWhite { D50, D65 };

/// The classic chart of 6 x 4 patches [X-Rite 2016], published for D50 and adapted to D65 by Bradford's matrix.
[[nodiscard]] ChartTable classic_chart(ChartEdition edition);

/// Lines `name,x,y,L,a,b`; a first line of these words, empty lines and lines that begin with # are passed over.
/// @throws IoError naming the line: it has not six fields, a place lies outside of [0, 1], L* outside of [0, 100], or a
/// name or place is taken; or if there are fewer than kMinPatches.
[[nodiscard]] ChartTable read_chart_table(const std::filesystem::path& file, ChartWhite white);

/// Whether patches stand where those of the classic chart do, in its order: find_chart() looks for nothing else.
[[nodiscard]] bool is_classic_layout(const ChartTable& table);

inline constexpr int kChartColumns = 6;
inline constexpr int kChartRows = 4;
/// Side of a patch over the distance of two, of the classic chart and its smaller copies: 0.85 to 0.9.
inline constexpr double kPatchSide = 0.87;
/// Place across the chart of a patch that `index` others come before, of `count` in a row or column.
[[nodiscard]] constexpr double patch_place(int index, int count) {
  return (0.5 * kPatchSide + index) / (count - 1 + kPatchSide);
}

}  // namespace patinate::capture
