#include "capture/unlighting/leave_one_out.h"

#include <algorithm>
#include <cmath>

#include "capture/unlighting/unlight_work.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"

namespace patinate::capture {

namespace {

/// Texels that are predicted, evenly picked.
constexpr std::int64_t kMaxLeftOutTexels = 20'000, kLeftOutTexelsAChunk = 64;

/// Prediction of a lamp's samples.
struct Predicted {
  std::vector<double> ratios;
  double squares = 0.0, values = 0.0;
  std::int64_t num_clean = 0;
};

void predict(const UnlightWork& work, const UnlightResult& result, const TexelFitOptions& options, int x, int y,
             TexelSamples& texel, std::vector<Predicted>& lamps) {
  work.load(x, y, texel);
  const std::vector<SampleState> before = texel.state;
  for (int k = 0; k < work.num_lights; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (before[i] != SampleState::Clean) continue;
    texel.state = before;
    texel.state[i] = SampleState::Invalid;
    const TexelFit fit = fit_texel(texel, options);
    if (!fit.is_determined) continue;
    const double cosine = std::max(0.0, fit.normal.dot(texel.direction[i]));
    double predicted = 0.0, seen = 0.0;
    for (int c = 0; c < work.num_channels; ++c) {
      const auto at = texel.index(k, c);
      predicted += fit.albedo[c] * (texel.irradiance[at] * cosine + texel.ambient[at]);
      predicted += fit.gain * highlight_value(texel, k, c, fit.normal);
      seen += texel.value[at];
    }
    if (!(predicted > 0.0)) continue;
    lamps[i].ratios.push_back(std::abs(predicted - seen) / predicted);
    if (result.samples.at(x, y, k) != static_cast<std::uint8_t>(SampleState::Clean)) continue;
    lamps[i].squares += (predicted - seen) * (predicted - seen);
    lamps[i].values += seen;
    ++lamps[i].num_clean;
  }
}

}  // namespace

std::vector<LeaveOneOutError> leave_one_out(const UnlightInput& input, const UnlightOptions& options,
                                            const UnlightResult& result, const RunControl& control) {
  const UnlightWork work(input, options, result);
  const TexelFitOptions fit_options = work.fit_options();
  const std::vector<std::int64_t> texels = work.spread_texels(kMaxLeftOutTexels);
  const std::vector<Predicted> zero(static_cast<std::size_t>(work.num_lights));
  const auto map = [&](std::int64_t begin, std::int64_t end) {
    std::vector<Predicted> lamps = zero;
    TexelSamples texel;
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t at = texels[i];
      const int x = static_cast<int>(at % work.width), y = static_cast<int>(at / work.width);
      if (result.mask.at(x, y) != 0) predict(work, result, fit_options, x, y, texel, lamps);
    }
    return lamps;
  };
  std::vector<Predicted> lamps =
      parallel_reduce(static_cast<std::int64_t>(texels.size()), kLeftOutTexelsAChunk, control, zero, map,
                      [](std::vector<Predicted> a, const std::vector<Predicted>& b) {
                        for (std::size_t k = 0; k < a.size(); ++k) {
                          a[k].ratios.insert(a[k].ratios.end(), b[k].ratios.begin(), b[k].ratios.end());
                          a[k].squares += b[k].squares;
                          a[k].values += b[k].values;
                          a[k].num_clean += b[k].num_clean;
                        }
                        return a;
                      });
  std::vector<LeaveOneOutError> errors;
  for (Predicted& lamp : lamps) {
    LeaveOneOutError error{.num_samples = static_cast<std::int64_t>(lamp.ratios.size())};
    if (lamp.num_clean > 0 && lamp.values > 0.0)
      error.rms = std::sqrt(lamp.squares * static_cast<double>(lamp.num_clean)) / lamp.values;
    if (!lamp.ratios.empty()) error.median = median(std::move(lamp.ratios));
    errors.push_back(error);
  }
  return errors;
}

}  // namespace patinate::capture
