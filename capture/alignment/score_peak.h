/// \file
/// Where the scores of a template match have their peak, to a fraction of a pixel.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace cv {
class Mat;
}

namespace patinate::capture {

struct ScorePeak {
  Eigen::Vector2i pixel;     ///< Pixel of the largest score.
  Eigen::Vector2d fraction;  ///< From there to the peak of a parabola through the nine scores around it: (-1, 1).
  double score = 0.0;
};

/// @param scores  Float, one channel, 3 x 3 or more: normalized correlations.
/// @param least_score  Below it there is no peak. @param least_bend  Nor where the parabola's second derivative is less
/// than this in some direction (along a lone crack it is 0).
/// @returns nothing, too, for a peak at the border.
[[nodiscard]] std::optional<ScorePeak> find_score_peak(const cv::Mat& scores, double least_score, double least_bend);

}  // namespace patinate::capture
