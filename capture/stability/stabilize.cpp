#include "capture/stability/stabilize.h"

#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/stability/odd_frames.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kPairError = 0.05;  ///< Error of a motion between equal pictures, px: detail that changed adds to it.
constexpr double kIdentityError = 0.1;  ///< Error of "did not move".
constexpr double kFallbackError = 1e3;  ///< Error of a frame that nothing ties: any other pair overrules it.
constexpr int kReweightingRounds = 5;   ///< Rounds of reweighting.
constexpr double kCauchy = 2.0;         ///< Disagreements beyond so many errors count less.

using Corners = Eigen::Matrix<double, 2, 3>;

struct Edge {
  int reference, frame;
  Eigen::Affine2d motion;
  double error;
  double weight;
};

std::vector<Edge> usable_edges(int num_frames, const std::vector<FramePair>& pairs) {
  std::vector<Edge> edges;
  for (const FramePair& pair : pairs) {
    if (pair.reference < 0 || pair.frame < 0 || pair.reference >= num_frames || pair.frame >= num_frames) {
      throw InvalidInput("stabilize: a pair names frame " + std::to_string(std::max(pair.reference, pair.frame)) +
                         " of " + std::to_string(num_frames));
    }
    if (!can_be_laid_over(pair)) continue;
    const double similarity = pair.is_motion_measured ? pair.motion.similarity : pair.similarity_before;
    const double error = pair.is_motion_measured ? std::hypot(kPairError, pair.motion.residual_px) : kIdentityError;
    edges.push_back({pair.reference, pair.frame, pair.motion.frame_from_reference, error / similarity, 1.0});
  }
  for (int i = 1; i < num_frames; ++i) edges.push_back({i - 1, i, Eigen::Affine2d::Identity(), kFallbackError, 1.0});
  return edges;
}

/// Corners of the first frame in all frames; those of frame 0 are given.
void solve_round(const std::vector<Edge>& edges, std::vector<Corners>& corners) {
  const int n = static_cast<int>(corners.size()) - 1;
  Eigen::SparseMatrix<double> normal(2 * n, 2 * n);
  Eigen::Matrix<double, Eigen::Dynamic, 3> right = Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(2 * n, 3);
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int i, int j, const Eigen::Matrix2d& block) {
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < 2; ++c) entries.emplace_back(2 * (i - 1) + r, 2 * (j - 1) + c, block(r, c));
    }
  };
  for (const Edge& edge : edges) {
    // Residual q_frame - (A q_reference + t), for each corner q.
    const Eigen::Matrix2d a = edge.motion.linear();
    const double w = edge.weight / (edge.error * edge.error);
    Corners offset = edge.motion.translation().replicate<1, 3>();
    if (edge.reference == 0) offset += a * corners[0];
    if (edge.frame == 0) offset -= corners[0];
    if (edge.frame != 0) {
      add(edge.frame, edge.frame, w * Eigen::Matrix2d::Identity());
      right.middleRows<2>(2 * (edge.frame - 1)) += w * offset;
    }
    if (edge.reference != 0) {
      add(edge.reference, edge.reference, w * (a.transpose() * a));
      right.middleRows<2>(2 * (edge.reference - 1)) -= w * (a.transpose() * offset);
    }
    if (edge.frame != 0 && edge.reference != 0) {
      add(edge.frame, edge.reference, -w * a);
      add(edge.reference, edge.frame, -w * a.transpose());
    }
  }
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
  const Eigen::Matrix<double, Eigen::Dynamic, 3> solution = solver.solve(right);
  for (int i = 1; i <= n; ++i) corners[i] = solution.middleRows<2>(2 * (i - 1));
}

double disagreement(const Edge& edge, const std::vector<Corners>& corners) {
  const Corners expected = (edge.motion.linear() * corners[edge.reference]).colwise() + edge.motion.translation();
  return (corners[edge.frame] - expected).norm() / std::sqrt(3.0);
}

/// Root mean square disagreement, weighted: of all edges, and of those of each frame.
void measure_residuals(const std::vector<Edge>& edges, const std::vector<Corners>& corners, StabilizedMotions& result) {
  const std::size_t n = corners.size();
  std::vector<double> sums(n + 1, 0.0), weights(n + 1, 0.0);  // The last one is that of all.
  for (const Edge& edge : edges) {
    if (edge.error == kFallbackError) continue;
    const double d = disagreement(edge, corners);
    for (std::size_t at : {static_cast<std::size_t>(edge.reference), static_cast<std::size_t>(edge.frame), n}) {
      sums[at] += edge.weight * d * d;
      weights[at] += edge.weight;
    }
  }
  for (std::size_t i = 0; i < n; ++i)
    result.frame_residual_px.push_back(weights[i] > 0.0 ? std::sqrt(sums[i] / weights[i]) : 0.0);
  if (weights[n] > 0.0) result.residual_px = std::sqrt(sums[n] / weights[n]);
}

/// Catmull-Rom weights of the pixels at -1, 0, 1, 2.
std::array<double, 4> cubic_weights(double t) {
  return {0.5 * t * (-1 + t * (2 - t)), 1 + 0.5 * t * t * (-5 + 3 * t), 0.5 * t * (1 + t * (4 - 3 * t)),
          0.5 * t * t * (t - 1)};
}

void sample_cubic(const ImageF& image, double x, double y, std::span<float> out) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const std::array<double, 4> wx = cubic_weights(x - x0), wy = cubic_weights(y - y0);
  const auto column = [&](int i) { return std::clamp(x0 + i, 0, image.width() - 1); };
  const auto row = [&](int j) { return std::clamp(y0 + j, 0, image.height() - 1); };
  for (std::size_t c = 0; c < out.size(); ++c) {
    double sum = 0.0, low = 1e30, high = -1e30;
    for (int j = -1; j <= 2; ++j) {
      for (int i = -1; i <= 2; ++i) {
        const double value = static_cast<double>(image.at(column(i), row(j), static_cast<int>(c)));
        sum += wx[i + 1] * wy[j + 1] * value;
        low = std::min(low, value);
        high = std::max(high, value);
      }
    }
    out[c] = static_cast<float>(std::clamp(sum, low, high));
  }
}

}  // namespace

StabilizedMotions solve_motions(int num_frames, const std::vector<FramePair>& pairs, int width, int height) {
  StabilizedMotions result;
  std::vector<Edge> edges = usable_edges(num_frames, pairs);
  result.unlinked_frames = frames_outside(group_frames(num_frames, pairs, can_be_laid_over));
  Corners first;
  first << 0, width, 0, 0, 0, height;
  std::vector<Corners> corners(static_cast<std::size_t>(std::max(1, num_frames)), first);
  for (int round = 0; round < kReweightingRounds && num_frames > 1; ++round) {
    solve_round(edges, corners);
    for (Edge& edge : edges) {
      const double r = disagreement(edge, corners) / (kCauchy * edge.error);
      edge.weight = 1.0 / (1.0 + r * r);
    }
  }
  measure_residuals(edges, corners, result);
  for (const Corners& q : corners) {
    Eigen::Affine2d motion;
    motion.setIdentity();
    motion.linear().col(0) = (q.col(1) - q.col(0)) / width;
    motion.linear().col(1) = (q.col(2) - q.col(0)) / height;
    motion.translation() = q.col(0);
    result.frame_from_first.push_back(motion);
  }
  return result;
}

ImageF resample_frame(const ImageF& image, const Eigen::Affine2d& source_from_out, int width, int height,
                      ImageU8& valid, const RunControl& control) {
  constexpr std::int64_t kRowsPerChunk = 8;
  constexpr double kEdge = 1e-6;  // px; rounding.
  ImageF out(width, height, image.channels());
  valid = ImageU8(width, height, 1, 255);
  parallel_for(height, kRowsPerChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        const Eigen::Vector2d p = source_from_out * Eigen::Vector2d(x, y);
        const bool is_seen = p.x() >= -kEdge && p.y() >= -kEdge && p.x() <= image.width() - 1 + kEdge &&
                             p.y() <= image.height() - 1 + kEdge;
        if (!is_seen) valid.at(x, y) = 0;
        sample_cubic(image, std::clamp(p.x(), 0.0, image.width() - 1.0), std::clamp(p.y(), 0.0, image.height() - 1.0),
                     out.pixel(x, y));
      }
    }
  });
  return out;
}

}  // namespace patinate::capture
