// How much a texel's highlight is its own, and how much its material's.
#include <array>
#include <cmath>
#include <vector>

#include "capture/unlighting/material_maps.h"
#include "capture/unlighting/specular_choice.h"
#include "libcommon/core/parallel.h"

namespace patinate::capture {

namespace {

/// See docs/algorithms/materials.md, step 5.
constexpr std::int64_t kMaxFreedomTexels = 2000, kFreedomTexelsAChunk = 32;
/// Deviation of a texel's highlight (docs/algorithms/materials.md, step 5).
constexpr std::array<double, 2> kWider{0.2, 0.4};

/// Cost of each texel's left-out lamps; negative where nothing is predicted.
std::vector<double> costs(const UnlightWork& work, const std::vector<std::int64_t>& texels, double freedom,
                          const RunControl& control) {
  TexelFitOptions options = work.fit_options();
  options.small_step = 1e-5;
  std::vector<double> found(texels.size(), -1.0);
  parallel_for(static_cast<std::int64_t>(texels.size()), kFreedomTexelsAChunk, control,
               [&](std::int64_t begin, std::int64_t end) {
                 TexelSamples plain, texel;
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                   const int x = static_cast<int>(texels[i] % work.width), y = static_cast<int>(texels[i] / work.width);
                   if (!(work.specular.at(x, y, 0) > 0.0f)) continue;
                   work.load_raw(x, y, plain);
                   work.load(x, y, texel);
                   texel.highlight.freedom = freedom;
                   found[i] = left_out_cost(texel, plain.variance, options, x + y);
                 }
               });
  return found;
}

}  // namespace

double choose_freedom(const UnlightWork& work, const RunControl& control) {
  const RunControl silent = control.silent();
  const std::vector<std::int64_t> texels = work.spread_texels(kMaxFreedomTexels);
  double best = work.highlight_freedom;
  std::vector<double> least = costs(work, texels, best, silent);
  for (const double freedom : kWider) {
    std::vector<double> next = costs(work, texels, freedom, silent);
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < texels.size(); ++i) {
      if (next[i] < 0.0 || least[i] < 0.0) continue;
      sum += next[i] - least[i];
      squares += (next[i] - least[i]) * (next[i] - least[i]);
    }
    if (!(sum < -kTold * std::sqrt(squares))) break;
    best = freedom;
    least = std::move(next);
  }
  control.report(1.0);
  return best;
}

}  // namespace patinate::capture
