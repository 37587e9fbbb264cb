// Window of the mode filter that suits a layer: the one that best predicts what it does not see.
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/image/filters.h"
#include "patinate/capture/thickness.h"

namespace patinate::capture {

namespace {

constexpr double kNarrowest_px = 6.0;     ///< See docs/algorithms/mode_filter.md.
constexpr double kSigmasOfLayer = 6.0;    ///< A window as wide as the layer: three sigmas to either side.
constexpr double kStep = 1.5;             ///< From one window that is tried to the next.
constexpr double kCrackDeviations = 4.0;  ///< From where on brighter light is a crack's.
/// Rank of the distances from a crack's edge: in a band of one width they are spread evenly up to half of it.
constexpr double kDistanceRank = 0.9;
constexpr int kSmallestGap_px = 12;      ///< Grain that neighbors share is not to be foretold from them.
constexpr int kLargestGap_px = 32;       ///< See docs/algorithms/mode_filter.md, Squares.
constexpr std::size_t kMinSquares = 50;  ///< Fewer squares do not rank windows.
/// Standard error of the median of |d|, over it, times the root of their number: d is normal.
constexpr double kErrorOfMedian = 1.17;

/// How wide the layer's cracks are: light that is brighter than the layer around by more than four deviations of it.
int crack_width(const ImageF& light, const ImageU8& known, const ThicknessOptions& options, const RunControl& control) {
  const ImageF filled = fill_cracks(light, known, options, control);
  std::vector<float> sizes;
  for (std::int64_t i = 0; i < light.num_pixels(); ++i)
    if (known.data()[i] != 0) sizes.push_back(std::abs(light.data()[i] - filled.data()[i]));
  const double limit = kCrackDeviations * kSigmaOfMad * static_cast<double>(median(std::move(sizes)));
  cv::Mat1b cracks(light.height(), light.width(), std::uint8_t{0});
  for (std::int64_t i = 0; i < light.num_pixels(); ++i) {
    if (known.data()[i] != 0 && static_cast<double>(light.data()[i] - filled.data()[i]) > limit) cracks.data[i] = 255;
  }
  cv::Mat1f distances;
  cv::distanceTransform(cracks, distances, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  std::vector<float> inside;
  for (std::int64_t i = 0; i < light.num_pixels(); ++i)
    if (cracks.data[i] != 0)
      inside.push_back(distances(static_cast<int>(i / light.width()), static_cast<int>(i % light.width())));
  if (inside.empty()) return kSmallestGap_px;
  const auto rank = static_cast<std::size_t>(kDistanceRank * static_cast<double>(inside.size() - 1));
  const double width = 2.0 / kDistanceRank * static_cast<double>(value_at_rank(inside, rank));
  return std::clamp(static_cast<int>(std::lround(width)), kSmallestGap_px, kLargestGap_px);
}

bool is_black(int x, int y, int side) { return (x / side + y / side) % 2 == 1; }

/// The white squares that lie in the layer.
ImageU8 white_squares(const ImageU8& known, int side) {
  ImageU8 white = known;
  for (int y = 0; y < white.height(); ++y) {
    for (int x = 0; x < white.width(); ++x) {
      if (is_black(x, y, side)) white.at(x, y) = 0;
    }
  }
  return white;
}

/// The black squares of which half lies in the layer, as their middle light and what is foretold of it.
class HeldOut {
 public:
  HeldOut(const ImageF& light, const ImageU8& known, int side)
      : light_(light), known_(known), side_(side), white_(white_squares(known, side)) {}

  [[nodiscard]] bool is_enough() const { return num_squares() >= kMinSquares; }

  /// Error at the squares: |middle light - predicted| / predicted, the median.
  [[nodiscard]] double miss_of(const ThicknessOptions& options, const RunControl& control) const {
    // The white squares' values are carried into the black ones by their neighbors, three quarters of a side away.
    constexpr double kCarried = 0.75;
    const ImageF foretold =
        gaussian_blur(fill_cracks(light_, white_, options, control), white_, kCarried * side_, control.silent());
    std::vector<double> misses;
    visit([&](const std::vector<std::int64_t>& pixels) {
      const double expected = middle(foretold, pixels);
      if (expected > 0.0) misses.push_back(std::abs(middle(light_, pixels) - expected) / expected);
    });
    return median(std::move(misses));
  }

  [[nodiscard]] std::size_t num_squares() const {
    std::size_t n = 0;
    visit([&](const std::vector<std::int64_t>&) { ++n; });
    return n;
  }

 private:
  static double middle(const ImageF& image, const std::vector<std::int64_t>& pixels) {
    std::vector<float> values;
    for (const std::int64_t i : pixels) values.push_back(image.data()[i]);
    return static_cast<double>(median(std::move(values)));
  }

  template <class Visit>
  void visit(const Visit& visit_square) const {
    for (int y0 = 0; y0 < light_.height(); y0 += side_) {
      for (int x0 = 0; x0 < light_.width(); x0 += side_) {
        if (!is_black(x0, y0, side_)) continue;
        std::vector<std::int64_t> pixels;
        for (int y = y0; y < std::min(y0 + side_, light_.height()); ++y) {
          for (int x = x0; x < std::min(x0 + side_, light_.width()); ++x) {
            const std::int64_t i = std::int64_t{y} * light_.width() + x;
            if (known_.data()[i] != 0) pixels.push_back(i);
          }
        }
        if (2 * pixels.size() >= static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_))
          visit_square(pixels);
      }
    }
  }

  const ImageF& light_;
  const ImageU8& known_;
  int side_;
  ImageU8 white_;
};

}  // namespace

LayerWindow choose_layer_window(const ImageF& transmittance, const ImageU8& mask, const ThicknessOptions& options,
                                const RunControl& control) {
  const ImageU8 known = mask.empty() ? ImageU8(transmittance.width(), transmittance.height(), 1, 255) : mask;
  const auto num_known = std::count_if(known.values().begin(), known.values().end(), [](auto v) { return v != 0; });
  const double widest = std::max(kNarrowest_px, std::sqrt(static_cast<double>(num_known)) / kSigmasOfLayer);
  ThicknessOptions tried = options;
  tried.mode_filter.spatial_sigma_px = std::min(kModeFilterWindow_px, widest);
  LayerWindow window{.sigma_px = *tried.mode_filter.spatial_sigma_px};
  window.gap_px = crack_width(transmittance, known, tried, control.part(0.0, 0.2));
  const HeldOut held_out(transmittance, known, window.gap_px);
  if (!held_out.is_enough()) return window;
  window.is_chosen = true;
  const RunControl quiet = control.silent();
  const auto miss_of = [&](double sigma) {
    control.throw_if_stopped();
    tried.mode_filter.spatial_sigma_px = sigma;
    return held_out.miss_of(tried, quiet);
  };
  const auto is_allowed = [&](double sigma) { return sigma >= kNarrowest_px / std::sqrt(kStep) && sigma <= widest; };
  double best = miss_of(window.sigma_px), wider = 0.0, wider_miss = 0.0;
  control.report(0.4);
  // Narrower as long as that is better; else wider.
  for (double sigma = window.sigma_px; is_allowed(sigma / kStep);) {
    sigma /= kStep;
    const double miss = miss_of(sigma);
    if (!(miss < best)) break;
    wider = window.sigma_px, wider_miss = best;
    window.sigma_px = sigma, best = miss;
  }
  control.report(0.7);
  for (double sigma = window.sigma_px; !(wider > 0.0) && is_allowed(sigma * kStep);) {
    sigma *= kStep;
    const double miss = miss_of(sigma);
    if (!(miss < best)) {
      wider = sigma, wider_miss = miss;
    } else {
      window.sigma_px = sigma, best = miss;
    }
  }
  const double error = kErrorOfMedian * best / std::sqrt(static_cast<double>(held_out.num_squares()));
  if (wider > 0.0 && wider_miss <= best + error) window.sigma_px = wider, best = wider_miss;
  window.sigma_px = std::round(window.sigma_px);
  window.foretold_to = kSigmaOfMad * best;
  control.report(1.0);
  return window;
}

}  // namespace patinate::capture
