#include "capture/handheld/lay_photo.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kMaxSamples = 4;  ///< A side; longer footprints are averaged over whole pixels first.

/// Catmull-Rom weights of the pixels at -1, 0, 1, 2.
std::array<double, 4> cubic_weights(double t) {
  return {0.5 * t * (-1 + t * (2 - t)), 1 + 0.5 * t * t * (-5 + 3 * t), 0.5 * t * (1 + t * (4 - 3 * t)),
          0.5 * t * t * (t - 1)};
}

/// Adds the sample, kept within the values around it so that edges do not ring. @param sum  A value for each of the
/// `C` channels.
template <std::size_t C>
void add_sample(const ImageF& image, const Eigen::Vector2d& at, std::span<double> sum) {
  const int x0 = static_cast<int>(std::floor(at.x())), y0 = static_cast<int>(std::floor(at.y()));
  const std::array<double, 4> wx = cubic_weights(at.x() - x0), wy = cubic_weights(at.y() - y0);
  std::array<std::int64_t, 4> columns{};
  for (int i = 0; i < 4; ++i) columns[i] = static_cast<std::int64_t>(C) * std::clamp(x0 + i - 1, 0, image.width() - 1);
  std::array<double, C> value{}, low, high;
  low.fill(1e30);
  high.fill(-1e30);
  for (int j = 0; j < 4; ++j) {
    const float* row =
        image.data() + static_cast<std::int64_t>(C) * image.width() * std::clamp(y0 + j - 1, 0, image.height() - 1);
    for (int i = 0; i < 4; ++i) {
      const double weight = wx[i] * wy[j];
      for (std::size_t c = 0; c < C; ++c) {
        const double v = static_cast<double>(row[columns[i] + static_cast<std::int64_t>(c)]);
        value[c] += weight * v;
        low[c] = std::min(low[c], v);
        high[c] = std::max(high[c], v);
      }
    }
  }
  for (std::size_t c = 0; c < C; ++c) sum[c] += std::clamp(value[c], low[c], high[c]);
}

/// The photograph reduced so that a footprint is at most kMaxSamples pixels long, and the map to it.
struct Source {
  ImageF reduced;  ///< Empty: the photograph itself.
  Eigen::Matrix3d source_from_reference;
  int num_samples = 1;  ///< A side.
};

Source make_source(const ImageF& photo, const Eigen::Matrix3d& photo_from_reference, double footprint,
                   const RunControl& control) {
  Source source{{}, photo_from_reference, 1};
  const int factor = static_cast<int>(std::floor(footprint / kMaxSamples)) + 1;
  if (factor > 1) {
    const int width = std::max(1, photo.width() / factor), height = std::max(1, photo.height() / factor);
    source.reduced = downscale_area(photo, width, height, control);
    const double sx = static_cast<double>(width) / photo.width(), sy = static_cast<double>(height) / photo.height();
    Eigen::Matrix3d scale;
    scale << sx, 0, 0.5 * sx - 0.5, 0, sy, 0.5 * sy - 0.5, 0, 0, 1;
    source.source_from_reference = scale * photo_from_reference;
    footprint /= factor;
  }
  constexpr double kSame = 1.05;  // A photograph as fine as the reference is not blurred.
  source.num_samples = footprint > kSame ? static_cast<int>(std::ceil(footprint)) : 1;
  return source;
}

}  // namespace

double fineness(const Eigen::Matrix3d& reference_from_photo, int photo_width, int photo_height) {
  const Eigen::Vector3d middle(0.5 * (photo_width - 1), 0.5 * (photo_height - 1), 1.0);
  const double z = reference_from_photo.row(2).dot(middle);
  return std::sqrt(std::abs(z * z * z / reference_from_photo.determinant()));
}

ImageF lay_photo(const ImageF& photo, const Eigen::Matrix3d& reference_from_photo, int width, int height,
                 ImageU8& shown, const RunControl& control) {
  const double determinant = reference_from_photo.determinant();
  if (!reference_from_photo.allFinite() || !(std::abs(determinant) > 1e-12))
    throw InvalidInput("a photograph's transform must be invertible");
  const RunControl quiet = control.silent();
  const Eigen::Matrix3d photo_from_reference = reference_from_photo.inverse();
  const Source source =
      make_source(photo, photo_from_reference, fineness(reference_from_photo, photo.width(), photo.height()), quiet);
  const ImageF& from = source.reduced.empty() ? photo : source.reduced;
  const int k = source.num_samples;
  ImageF out(width, height, photo.channels());
  shown = ImageU8(width, height, 1, 255);
  constexpr std::int64_t kRowsPerChunk = 8;
  constexpr double kEdge = 0.5 + 1e-6;  // Pixels are squares around their centers.
  if (photo.channels() != 1 && photo.channels() != 3)
    throw InvalidInput("a photograph has one channel or three, not " + std::to_string(photo.channels()));
  const auto add = photo.channels() == 1 ? add_sample<1> : add_sample<3>;
  const double right = from.width() - 1.0, bottom = from.height() - 1.0;
  parallel_for(height, kRowsPerChunk, quiet, [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> sum(static_cast<std::size_t>(photo.channels()));
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        std::fill(sum.begin(), sum.end(), 0.0);
        for (int sample = 0; sample < k * k; ++sample) {
          const Eigen::Vector2d offset((sample % k + 0.5) / k - 0.5, (sample / k + 0.5) / k - 0.5);
          const Eigen::Vector3d p = source.source_from_reference * (Eigen::Vector2d(x, y) + offset).homogeneous();
          const bool is_before = p.z() > 0.0;
          const Eigen::Vector2d at = is_before ? p.hnormalized().eval() : Eigen::Vector2d(-1e9, -1e9);
          const bool is_inside =
              at.x() >= -kEdge && at.y() >= -kEdge && at.x() <= right + kEdge && at.y() <= bottom + kEdge;
          if (!is_inside) shown.at(x, y) = 0;
          add(from, {std::clamp(at.x(), 0.0, right), std::clamp(at.y(), 0.0, bottom)}, sum);
        }
        const auto pixel = out.pixel(x, y);
        for (std::size_t c = 0; c < sum.size(); ++c) pixel[c] = static_cast<float>(sum[c] / (k * k));
      }
    }
  });
  return out;
}

}  // namespace patinate::capture
