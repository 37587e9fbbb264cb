#include "capture/unlighting/specular_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "capture/unlighting/specular_tiles.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"

namespace patinate::capture {

namespace {

constexpr double kNearSigmaTiles = 0.5;  ///< Some 50 texels vote: materials may change within the window of the lobes.
constexpr double kFadeFrom = 0.75, kBelieved = 0.85;  ///< Share of the texels near.

/// Whether a texel costs less with its highlight; the same texels are asked that highlights are summed over.
class TexelChoice {
 public:
  explicit TexelChoice(const UnlightWork& work) : work_(work), options_(work.fit_options()) {}

  /// @returns 1 with it, 0 without it, nothing where it has none or a fit fails.
  [[nodiscard]] std::optional<float> operator()(int x, int y) {
    if (!work_.is_surface(x, y) || !(work_.specular.at(x, y, 0) > 0.0f)) return std::nullopt;
    work_.load_raw(x, y, matt_);
    work_.load(x, y, glossy_);
    const TexelFit without = fit_texel(matt_, options_), with = fit_texel(glossy_, options_);
    if (!without.is_determined || !with.is_determined) return std::nullopt;
    return robust_cost(glossy_, matt_.variance, with, options_) < robust_cost(matt_, matt_.variance, without, options_)
               ? 1.0f
               : 0.0f;
  }

 private:
  const UnlightWork& work_;
  TexelFitOptions options_;
  TexelSamples matt_, glossy_;
};

/// Sums over tiles: texels that were asked, and those that cost less with their highlight.
ImageF tile_votes(const UnlightWork& work, const RunControl& control) {
  ImageF votes((work.width + kSpecularTile - 1) / kSpecularTile, (work.height + kSpecularTile - 1) / kSpecularTile, 2);
  parallel_for(votes.height(), 1, control, [&](std::int64_t row, std::int64_t) {
    TexelChoice is_better(work);
    const int ty = static_cast<int>(row);
    for (int y = ty * kSpecularTile; y < std::min(work.height, (ty + 1) * kSpecularTile); ++y) {
      for (int x = 0; x < work.width; ++x) {
        if (!is_specular_sample(x, y)) continue;
        if (const std::optional<float> vote = is_better(x, y)) {
          votes.at(x / kSpecularTile, ty, 0) += 1.0f;
          votes.at(x / kSpecularTile, ty, 1) += *vote;
        }
      }
    }
  });
  return votes;
}

/// [0, 1]
double belief_at(const ImageF& votes, int x, int y) {
  double asked = 0.0, better = 0.0;
  for (const TileShare& tile : tiles_around(votes, x, y)) {
    asked += tile.weight * static_cast<double>(votes.at(tile.x, tile.y, 0));
    better += tile.weight * static_cast<double>(votes.at(tile.x, tile.y, 1));
  }
  return asked > 0.0 ? std::clamp((better / asked - kFadeFrom) / (kBelieved - kFadeFrom), 0.0, 1.0) : 0.0;
}

}  // namespace

double robust_cost(const TexelSamples& samples, const std::vector<double>& plain_variance, const TexelFit& fit,
                   const TexelFitOptions& options) {
  const double most = options.reject ? options.rejection_width() * options.rejection_width() * samples.num_channels
                                     : std::numeric_limits<double>::infinity();
  const double scale2 = options.noise_scale * options.noise_scale;
  double sum = 0.0;
  for (int k = 0; k < samples.num_lights; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const SampleState state = samples.state[i];
    if (state != SampleState::Clean && state != SampleState::Darker && state != SampleState::Brighter) continue;
    const double cosine = std::max(0.0, fit.normal.dot(samples.direction[i]));
    double cost = 0.0;
    for (int c = 0; c < samples.num_channels; ++c) {
      const auto at = samples.index(k, c), channel = static_cast<std::size_t>(c);
      const double off =
          samples.value[at] - fit.albedo[channel] * (samples.irradiance[at] * cosine + samples.ambient[channel]);
      cost += off * off / (scale2 * samples.variance[at]) + std::log(samples.variance[at] / plain_variance[at]);
    }
    sum += std::min(cost, most);
  }
  return sum;
}

void keep_shared_highlights(UnlightWork& work, const RunControl& control) {
  const ImageF votes = tile_votes(work, control.part(0.0, 0.8));
  const ImageF wide = gaussian_blur(votes, work.options.specular_window_px / kSpecularTile, control.part(0.8, 0.9));
  const ImageF near = gaussian_blur(votes, kNearSigmaTiles, control.part(0.9, 1.0));
  for (int y = 0; y < work.height; ++y) {
    for (int x = 0; x < work.width; ++x) {
      if (!(work.specular.at(x, y, 0) > 0.0f)) continue;
      const double belief = std::max(belief_at(wide, x, y), belief_at(near, x, y));
      work.specular.at(x, y, 0) *= static_cast<float>(belief);
      if (!(belief > 0.0)) work.specular.at(x, y, 1) = 0.0f;
    }
  }
}

}  // namespace patinate::capture
