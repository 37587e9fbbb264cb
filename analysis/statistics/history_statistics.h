/// \file
/// One history in numbers: what a comparison says of two, of one.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "patinate/analysis/texture_series.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

struct ColorClass {
  std::string name;
  std::array<double, 3> code{};  ///< sRGB, [0, 1].
};
/// "g1=#576a26". @throws InvalidInput
[[nodiscard]] ColorClass parse_color_class(const std::string& text);

/// Share of the pixels whose sRGB code is nearest to each class (Euclidean; the first of equally near ones). Codes, not
/// CIELAB: published class curves are counted so, and the figures then mean the same.
/// @param rgb  H x W x 3, linear. @param mask  H x W, 0 = outside; may be empty.
/// @throws InvalidInput if sizes differ, there is no class, or the mask covers nothing.
[[nodiscard]] std::vector<double> class_shares(const ImageF& rgb, const ImageU8& mask,
                                               const std::vector<ColorClass>& classes);

/// Quartiles over the places that age visibly.
struct TimeQuartiles {
  double q25 = 0.0, median = 0.0, q75 = 0.0;
};

/// Dark lines of a frame (find_cracks()).
struct CrackFigures {
  double share = 0.0;    ///< Share of the surface.
  double density = 0.0;  ///< Length of center lines on an area: per mm when is_metric, else per pixel looked at.
};

struct HistoryStatistics {
  std::vector<double> times;
  std::vector<std::array<double, 3>> mean_lab;
  std::vector<double> covered;  ///< Share with a visible change; empty for a single frame.
  std::vector<std::optional<double>>
      correlation_length;  ///< Correlation length of L*; mm when is_metric, else pixels of the size looked at.
  std::vector<std::vector<double>> class_shares;  ///< [time][class]; empty without classes.
  std::vector<CrackFigures> cracks;               ///< One a time.
  bool is_metric = false;
  double ages_share = 0.0;                         ///< Places that age visibly.
  std::optional<TimeQuartiles> onset, saturation;  ///< Nothing where nothing ages.
};

/// @param size  Longer side at which it is looked at, px; 0 = as it is. @param visible_delta_e  See texel_aging().
/// @throws InvalidInput, IoError. Same bits for any number of threads.
[[nodiscard]] HistoryStatistics history_statistics(const TextureSeries& series, const std::vector<ColorClass>& classes,
                                                   int size, double visible_delta_e, const RunControl& control = {});

}  // namespace patinate::analysis
