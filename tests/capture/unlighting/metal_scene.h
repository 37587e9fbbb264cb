/// \file
/// The synthetic mold of metal as unlighting takes it, and how well lamps that were left out are foretold.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "datasets_synthetic/mold.h"
#include "patinate/capture/unlight.h"

namespace patinate::testing_support {

/// One step, with the truth in its pixels; nothing moves, so that steps share their pixels.
struct MetalStep {
  std::unique_ptr<const Mesh> surface;
  capture::UnlightInput input;  ///< With the surface as blockers; normals of the scan are off by a degree or so.
  ImageF albedo;
  ImageF reflectance;  ///< F0, x 3.
  ImageF roughness;
  ImageF metalness;
};
/// Photographs of 8 bits with noise; ambient light, motion and drift are off.
/// @param coat_roughness  Of a clear coat over all of it, of F0 kCoatF0: its lobe is added where a lamp's light
/// arrives, and what comes from below loses what the coat reflects on the way in and out (Schlick's term of both). The
/// truth that a step tells is of what lies below.
[[nodiscard]] std::vector<MetalStep> metal_steps(datasets::MoldOptions options,
                                                 std::optional<double> coat_roughness = {});
inline constexpr double kCoatF0 = 0.04;

/// How far photographs are off what is foretold of them.
struct ForetoldErrors {
  double mean = 0.0;    ///< Mean of |foretold - seen| over the mean of what is seen.
  double median = 0.0;  ///< Median of |foretold - seen| / (seen + 0.02).
};
/// Of lamp `lamp`, by a fit that has not seen its photograph. Samples that count: valid ones of determined texels that
/// face the lamp and lie in no shadow.
[[nodiscard]] ForetoldErrors foretold(const capture::UnlightInput& input, const capture::UnlightOptions& options,
                                      std::size_t lamp);
/// Without a lamp.
[[nodiscard]] capture::UnlightInput without_lamp(const capture::UnlightInput& input, std::size_t lamp);
[[nodiscard]] ForetoldErrors foretold(const capture::UnlightInput& input, const capture::UnlightOptions& options,
                                      const capture::UnlightResult& of_others, std::size_t lamp);

}  // namespace patinate::testing_support
