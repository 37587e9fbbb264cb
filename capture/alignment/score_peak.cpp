#include "capture/alignment/score_peak.h"

#include <cmath>
#include <opencv2/core.hpp>

namespace patinate::capture {

std::optional<ScorePeak> find_score_peak(const cv::Mat& scores, double least_score, double least_bend) {
  double best = 0.0;
  cv::Point at;
  cv::minMaxLoc(scores, nullptr, &best, nullptr, &at);
  if (!(best > least_score) || at.x < 1 || at.y < 1 || at.x > scores.cols - 2 || at.y > scores.rows - 2)
    return std::nullopt;
  const auto s = [&](int dx, int dy) { return static_cast<double>(scores.at<float>(at.y + dy, at.x + dx)); };
  const double gx = 0.5 * (s(1, 0) - s(-1, 0)), gy = 0.5 * (s(0, 1) - s(0, -1));
  const double xx = s(1, 0) - 2 * best + s(-1, 0), yy = s(0, 1) - 2 * best + s(0, -1);
  const double xy = 0.25 * (s(1, 1) - s(-1, 1) - s(1, -1) + s(-1, -1));
  const double bend = -0.5 * (xx + yy) - std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  if (!(bend > least_bend)) return std::nullopt;
  const double determinant = xx * yy - xy * xy;
  const Eigen::Vector2d fraction(-(yy * gx - xy * gy) / determinant, -(xx * gy - xy * gx) / determinant);
  if (!(fraction.cwiseAbs().maxCoeff() < 1.0)) return std::nullopt;
  return ScorePeak{{at.x, at.y}, fraction, best};
}

}  // namespace patinate::capture
