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

constexpr double kNearSigmaTiles =
    0.5;                           ///< Some 50 texels are asked: materials may change within the window of the lobes.
constexpr double kBelieved = 2.0;  ///< Standard deviations of what is saved.

/// How much less a texel costs with its highlight; the same texels are asked that highlights are summed over.
class TexelChoice {
 public:
  explicit TexelChoice(const UnlightWork& work) : work_(work), options_(work.fit_options()) {}

  /// Cost of predicting its lamps; nothing where it has none or a fit fails.
  [[nodiscard]] std::optional<float> operator()(int x, int y) {
    if (!work_.is_surface(x, y) || !(work_.specular.at(x, y, 0) > 0.0f)) return std::nullopt;
    work_.load_raw(x, y, matt_);
    work_.load(x, y, glossy_);
    const double without = left_out_cost(matt_, matt_.variance, options_, x + y),
                 with = left_out_cost(glossy_, matt_.variance, options_, x + y);
    if (without < 0.0 || with < 0.0) return std::nullopt;
    return static_cast<float>(without - with);
  }

 private:
  const UnlightWork& work_;
  TexelFitOptions options_;
  TexelSamples matt_, glossy_;
};

/// Sums over tiles: what texels cost less with their highlight, and its square.
ImageF tile_votes(const UnlightWork& work, const RunControl& control) {
  ImageF votes((work.width + kSpecularTile - 1) / kSpecularTile, (work.height + kSpecularTile - 1) / kSpecularTile, 2);
  parallel_for(votes.height(), 1, control, [&](std::int64_t row, std::int64_t) {
    TexelChoice saved(work);
    const int ty = static_cast<int>(row);
    for (int y = ty * kSpecularTile; y < std::min(work.height, (ty + 1) * kSpecularTile); ++y) {
      for (int x = 0; x < work.width; ++x) {
        if (!is_specular_sample(x, y, work.highlight_step)) continue;
        if (const std::optional<float> vote = saved(x, y)) {
          votes.at(x / kSpecularTile, ty, 0) += *vote;
          votes.at(x / kSpecularTile, ty, 1) += *vote * *vote;
        }
      }
    }
  });
  return votes;
}

/// [0, 1]: the sum of what is saved, from none of its standard deviations to kBelieved.
double belief_at(const ImageF& votes, int x, int y) {
  double saved = 0.0, squares = 0.0;
  for (const TileShare& tile : tiles_around(votes, x, y)) {
    saved += tile.weight * static_cast<double>(votes.at(tile.x, tile.y, 0));
    squares += tile.weight * static_cast<double>(votes.at(tile.x, tile.y, 1));
  }
  return squares > 0.0 ? std::clamp(saved / (kBelieved * std::sqrt(squares)), 0.0, 1.0) : 0.0;
}

/// Cost of one lamp, whatever its state.
double lamp_cost(const TexelSamples& samples, const std::vector<double>& plain_variance, const TexelFit& fit,
                 const TexelFitOptions& options, int lamp) {
  const double most = options.reject ? options.rejection_width() * options.rejection_width() * samples.num_channels
                                     : std::numeric_limits<double>::infinity();
  const double scale2 = options.noise_scale * options.noise_scale;
  const double cosine = std::max(0.0, fit.normal.dot(samples.direction[lamp]));
  double cost = 0.0;
  for (int c = 0; c < samples.num_channels; ++c) {
    const auto at = samples.index(lamp, c), channel = static_cast<std::size_t>(c);
    const double off = samples.value[at] -
                       fit.albedo[channel] * (samples.irradiance[at] * cosine + samples.ambient[at]) -
                       fit.gain * highlight_value(samples, lamp, c, fit.normal);
    cost += off * off / (scale2 * samples.variance[at]) + std::log(samples.variance[at] / plain_variance[at]);
  }
  return std::min(cost, most);
}

}  // namespace

double robust_cost(const TexelSamples& samples, const std::vector<double>& plain_variance, const TexelFit& fit,
                   const TexelFitOptions& options) {
  double sum = 0.0;
  for (int k = 0; k < samples.num_lights; ++k) {
    const SampleState state = samples.state[k];
    if (state == SampleState::Clean || state == SampleState::Darker || state == SampleState::Brighter)
      sum += lamp_cost(samples, plain_variance, fit, options, k);
  }
  return sum;
}

double left_out_mean(TexelSamples& samples, const TexelFitOptions& options, int first,
                     const std::function<double(const TexelFit&, int lamp)>& cost) {
  constexpr int kEnough = 5;  // Lamps that are left out.
  const int every = std::max(1, (samples.num_lights + kEnough - 1) / kEnough);
  const std::vector<SampleState> before = samples.state;
  double sum = 0.0;
  int count = 0;
  for (int k = first % every; k < samples.num_lights; k += every) {
    const auto i = static_cast<std::size_t>(k);
    if (before[i] != SampleState::Clean) continue;
    samples.state = before;
    samples.state[i] = SampleState::Invalid;
    const TexelFit fit = fit_texel(samples, options);
    if (!fit.is_determined) return -1.0;
    sum += cost(fit, k);
    ++count;
  }
  samples.state = before;
  return count > 0 ? sum / count : -1.0;
}

double left_out_cost(TexelSamples& samples, const std::vector<double>& plain_variance, const TexelFitOptions& options,
                     int first) {
  return left_out_mean(samples, options, first, [&](const TexelFit& fit, int lamp) {
    return lamp_cost(samples, plain_variance, fit, options, lamp);
  });
}

bool keep_shared_highlights(UnlightWork& work, const RunControl& control) {
  const ImageF votes = tile_votes(work, control.part(0.0, 0.8));
  const ImageF wide = gaussian_blur(votes, work.options.specular_window_px / kSpecularTile, control.part(0.8, 0.9));
  const ImageF near = gaussian_blur(votes, kNearSigmaTiles, control.part(0.9, 1.0));
  bool has_faded = false;
  for (int y = 0; y < work.height; ++y) {
    for (int x = 0; x < work.width; ++x) {
      if (!(work.specular.at(x, y, 0) > 0.0f)) continue;
      const double belief = std::max(belief_at(wide, x, y), belief_at(near, x, y));
      if (belief < 1.0) has_faded = true;
      work.specular.at(x, y, 0) *= static_cast<float>(belief);
      if (!(belief > 0.0)) work.specular.at(x, y, 1) = 0.0f;
    }
  }
  return has_faded;
}

}  // namespace patinate::capture
