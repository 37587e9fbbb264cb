#include "capture/stability/frame_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/geometry/dense_solve.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kStartSide = 160;       ///< Pixels of the longer side where turns and sizes are tried.
constexpr int kFinestSide = 640;      ///< Finer detail adds time, not precision.
constexpr double kTrustedPeak = 0.8;  ///< A correlation as high as this needs no search.
constexpr int kMaxIterations = 30;    ///< It ends earlier where the motion rests.
constexpr double kConverged = 1e-3;   ///< Largest motion of a corner in the last step, px.
constexpr double kReliable = 0.5;     ///< Similarity of a motion that can be trusted.
constexpr double kMinShared = 0.1;    ///< Share of the picture.

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Sample {
  double value, dx, dy;
};

/// Bilinear value and gradient. @returns false outside.
bool bilinear_sample(const ImageF& image, double x, double y, Sample& out) {
  if (!(x >= 0.0) || !(y >= 0.0) || !(x < image.width() - 1) || !(y < image.height() - 1)) return false;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double fx = x - x0, fy = y - y0;
  const double a = static_cast<double>(image.at(x0, y0)), b = static_cast<double>(image.at(x0 + 1, y0));
  const double c = static_cast<double>(image.at(x0, y0 + 1)), d = static_cast<double>(image.at(x0 + 1, y0 + 1));
  out.dx = (1 - fy) * (b - a) + fy * (d - c);
  out.dy = (1 - fx) * (c - a) + fx * (d - b);
  out.value = (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
  return true;
}

/// Both frames at one reduction.
struct Pair {
  ImageF reference, frame;
};

Pair reduced(const PreparedFrame& reference, const PreparedFrame& frame, int longer_side) {
  const ImageF& a = reference.detail;
  const double factor = std::min(1.0, static_cast<double>(longer_side) / std::max(a.width(), a.height()));
  const int w = std::max(8, static_cast<int>(std::lround(a.width() * factor)));
  const int h = std::max(8, static_cast<int>(std::lround(a.height() * factor)));
  if (w >= a.width() || h >= a.height()) return {a, frame.detail};
  RunControl one_thread;
  one_thread.num_threads = 1;
  return {downscale_area(a, w, h, one_thread), downscale_area(frame.detail, w, h, one_thread)};
}

/// The motion at another reduction: pixel edges of both coincide.
Eigen::Affine2d rescaled(const Eigen::Affine2d& motion, double factor_x, double factor_y) {
  Eigen::Affine2d to = Eigen::Affine2d::Identity();
  to.linear().diagonal() << factor_x, factor_y;
  to.translation() << 0.5 * factor_x - 0.5, 0.5 * factor_y - 0.5;
  return to * motion * to.inverse();
}

struct Overlay {
  double similarity = 0.0;
  double share = 0.0;
  double gain = 1.0;    ///< Contrast of the frame against the reference.
  double spread = 0.0;  ///< Root mean square of frame / gain - reference.
};

Overlay overlay(const Pair& pair, const Eigen::Affine2d& motion) {
  double count = 0, aa = 0, bb = 0, ab = 0;
  for (int y = 0; y < pair.reference.height(); ++y) {
    for (int x = 0; x < pair.reference.width(); ++x) {
      const Eigen::Vector2d p = motion * Eigen::Vector2d(x, y);
      Sample s;
      if (!bilinear_sample(pair.frame, p.x(), p.y(), s)) continue;
      const double a = static_cast<double>(pair.reference.at(x, y));
      count += 1.0;
      aa += a * a;
      bb += s.value * s.value;
      ab += a * s.value;
    }
  }
  Overlay result;
  result.share = count / static_cast<double>(pair.reference.num_pixels());
  if (!(aa > 0.0) || !(bb > 0.0) || result.share < kMinShared) return result;
  result.similarity = ab / std::sqrt(aa * bb);
  result.gain = std::sqrt(bb / aa);
  result.spread = std::sqrt(std::max(0.0, (aa + bb / (result.gain * result.gain) - 2.0 * ab / result.gain) / count));
  return result;
}

/// Normal equations of one Gauss-Newton step around the picture's middle; parameters (a b c d e f) add
/// (a + b u + c v, d + e u + f v) to the motion, u and v in half sides.
void accumulate_step(const Pair& pair, const Eigen::Affine2d& motion, const Overlay& fit, Matrix6& normal,
                     Vector6& right) {
  const double half_w = 0.5 * (pair.reference.width() - 1), half_h = 0.5 * (pair.reference.height() - 1);
  const double limit = kTukeyLimit * std::max(fit.spread, 1e-9);
  normal.setZero();
  right.setZero();
  for (int y = 0; y < pair.reference.height(); ++y) {
    const double v = y / half_h - 1.0;
    for (int x = 0; x < pair.reference.width(); ++x) {
      const Eigen::Vector2d p = motion * Eigen::Vector2d(x, y);
      Sample s;
      if (!bilinear_sample(pair.frame, p.x(), p.y(), s)) continue;
      const double residual = s.value / fit.gain - static_cast<double>(pair.reference.at(x, y));
      if (std::abs(residual) >= limit) continue;
      const double t = residual / limit, weight = (1 - t * t) * (1 - t * t), u = x / half_w - 1.0;
      const double gx = s.dx / fit.gain, gy = s.dy / fit.gain;
      Vector6 j;
      j << gx, gx * u, gx * v, gy, gy * u, gy * v;
      normal.noalias() += weight * j * j.transpose();
      right.noalias() -= weight * residual * j;
    }
  }
}

/// @param shift_error  Standard deviation of the shift that the last step leaves, px.
Eigen::Affine2d refine(const Pair& pair, Eigen::Affine2d motion, double& shift_error) {
  const double half_w = 0.5 * (pair.reference.width() - 1), half_h = 0.5 * (pair.reference.height() - 1);
  Overlay fit = overlay(pair, motion);
  for (int i = 0; i < kMaxIterations && fit.share >= kMinShared; ++i) {
    Matrix6 normal;
    Vector6 right;
    accumulate_step(pair, motion, fit, normal, right);
    const double ridge = 1e-9 * normal.trace() + 1e-300;
    normal.diagonal().array() += ridge;
    const Vector6 step = solve_ldlt(normal, right);
    if (!step.allFinite()) break;
    shift_error = fit.spread * std::sqrt(std::max(0.0, solve_ldlt(normal, Vector6(Vector6::Unit(0)))[0]));
    Eigen::Affine2d next = motion;
    next.linear()(0, 0) += step[1] / half_w;
    next.linear()(0, 1) += step[2] / half_h;
    next.linear()(1, 0) += step[4] / half_w;
    next.linear()(1, 1) += step[5] / half_h;
    next.translation() += Eigen::Vector2d(step[0] - step[1] - step[2], step[3] - step[4] - step[5]);
    const Overlay better = overlay(pair, next);
    if (better.similarity < fit.similarity - 1e-6) break;
    motion = next;
    fit = better;
    if (step.lpNorm<1>() < kConverged) break;
  }
  return motion;
}

/// The frame seen through a motion of its own, for trying turns and sizes.
ImageF seen_through(const ImageF& image, const Eigen::Affine2d& motion) {
  ImageF out(image.width(), image.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const Eigen::Vector2d p = motion * Eigen::Vector2d(x, y);
      Sample s;
      out.at(x, y) = bilinear_sample(image, p.x(), p.y(), s) ? static_cast<float>(s.value) : 0.0f;
    }
  }
  return out;
}

/// Best of a few turns and sizes, each with its own shift, at the reduction of `pair`.
Eigen::Affine2d search_start(const Pair& pair) {
  const Eigen::Vector2d middle(0.5 * (pair.reference.width() - 1), 0.5 * (pair.reference.height() - 1));
  Eigen::Affine2d best = Eigen::Affine2d::Identity();
  double best_similarity = -2.0;
  for (double angle_deg : {0.0, -3.0, 3.0, -6.0, 6.0}) {
    for (double size : {1.0, 0.96, 1.04, 0.92, 1.08, 0.87, 1.15, 0.8, 1.25}) {
      Eigen::Affine2d turn = Eigen::Affine2d::Identity();
      turn.translate(middle).rotate(angle_deg * std::numbers::pi / 180.0).scale(size).translate(-middle);
      const FrameShift shift = measure_shift({pair.reference, {}}, {seen_through(pair.frame, turn), {}});
      const Eigen::Affine2d motion = turn * Eigen::Translation2d(shift.x, shift.y);
      const double similarity = overlay(pair, motion).similarity;
      if (similarity <= best_similarity) continue;
      best_similarity = similarity;
      best = motion;
    }
  }
  return best;
}

}  // namespace

double detail_similarity(const PreparedFrame& reference, const PreparedFrame& frame,
                         const Eigen::Affine2d& frame_from_reference) {
  if (!reference.detail.same_size(frame.detail)) throw InvalidInput("motion: the frames differ in size");
  return overlay({reference.detail, frame.detail},
                 rescaled(frame_from_reference, 1.0 / reference.scale_x, 1.0 / reference.scale_y))
      .similarity;
}

FrameMotion measure_motion(const PreparedFrame& reference, const PreparedFrame& frame) {
  const FrameShift shift = measure_shift(reference, frame);
  FrameMotion result;
  if (shift.status == ShiftStatus::NoTexture) return result;
  // Motions are kept at the reduction of `detail` until the end.
  Eigen::Affine2d motion = Eigen::Affine2d::Identity();
  motion.translation() << shift.x / reference.scale_x, shift.y / reference.scale_y;
  const int side = std::max(reference.detail.width(), reference.detail.height());
  const double full_w = reference.detail.width(), full_h = reference.detail.height();
  if (shift.peak < kTrustedPeak) {
    const Pair small = reduced(reference, frame, kStartSide);
    motion = rescaled(search_start(small), full_w / small.reference.width(), full_h / small.reference.height());
  }
  double error = 0.0;
  for (int level_side : {kStartSide, 2 * kStartSide, kFinestSide}) {
    if (level_side > kStartSide && level_side / 2 >= side) continue;  // The level before had every pixel.
    const Pair pair = reduced(reference, frame, level_side);
    const double fx = full_w / pair.reference.width(), fy = full_h / pair.reference.height();
    motion = rescaled(refine(pair, rescaled(motion, 1.0 / fx, 1.0 / fy), error), fx, fy);
  }
  result.similarity = overlay({reference.detail, frame.detail}, motion).similarity;
  result.residual_px = error * std::max(reference.scale_x, reference.scale_y);
  result.is_reliable = result.similarity >= kReliable;
  result.frame_from_reference = rescaled(motion, reference.scale_x, reference.scale_y);
  return result;
}

}  // namespace patinate::capture
