#include "analysis/grading/gloss_units.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/core/text.h"
#include "libcommon/output/microfacet.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

/// Full angles of the source's image and of the receptor's aperture, in the plane of incidence and across it, degrees
/// [ISO 2813:2014, table 1].
struct Meter {
  double angle_deg;
  double source_in, source_across;
  double receptor_in, receptor_across;
};
constexpr Meter kMeters[] = {{20, 0.75, 2.5, 1.80, 3.6}, {60, 0.75, 2.5, 4.4, 11.7}, {85, 0.75, 2.5, 4.0, 6.0}};
constexpr int kSourceSteps = 5;        // Along each side of the source's image.
constexpr int kLeastSteps = 24;        // Along each side of the receptor.
constexpr int kStepsPerLobe = 6;       // Along the width of a lobe that is narrower than the receptor.
constexpr double kGlassIndex = 1.567;  ///< Black glass [ISO 2813].
constexpr double kHighestF0 = 0.999;   // An index of 4,000; 1 has none.

/// Reflectance of unpolarized light, by Fresnel's equations.
double reflectance(double index, double cosine) {
  const double sine2 = (1.0 - cosine * cosine) / (index * index), inner = std::sqrt(1.0 - sine2);
  const double s = (cosine - index * inner) / (cosine + index * inner),
               p = (index * cosine - inner) / (index * cosine + inner);
  return 0.5 * (s * s + p * p);
}

/// A direction `in` and `across` degrees from the one at `angle` degrees from the normal z, toward +x or -x.
Vec3 direction(double angle_deg, double in_deg, double across_deg, double side) {
  const double theta = (angle_deg + in_deg) * std::numbers::pi / 180.0, phi = across_deg * std::numbers::pi / 180.0;
  return {side * std::sin(theta) * std::cos(phi), std::sin(phi), std::cos(theta) * std::cos(phi)};
}

/// @param lobe_deg  Width of the lobe in this direction.
int steps_of(double window_deg, double lobe_deg) {
  return std::max(kLeastSteps, static_cast<int>(std::ceil(kStepsPerLobe * window_deg / lobe_deg)));
}

double middle(int step, int steps, double width) { return ((step + 0.5) / steps - 0.5) * width; }

}  // namespace

double gloss_units(double angle_deg, double f0, double roughness) {
  const Meter* meter = std::find_if(std::begin(kMeters), std::end(kMeters),
                                    [angle_deg](const Meter& m) { return m.angle_deg == angle_deg; });
  if (meter == std::end(kMeters))
    throw InvalidInput("gloss: found an angle of " + number_text(angle_deg) + " degrees; expected 20, 60 or 85");
  const Vec3 normal = Vec3::UnitZ();
  // A lobe of half angles of about alpha = roughness^2 is twice as wide in reflected angles, and narrower across.
  const double lobe_deg = 2.0 * roughness * roughness * 180.0 / std::numbers::pi,
               across_deg = lobe_deg * std::cos(angle_deg * std::numbers::pi / 180.0);
  const int steps_in = steps_of(meter->receptor_in, lobe_deg),
            steps_across = steps_of(meter->receptor_across, across_deg);
  const double cell = meter->receptor_in * meter->receptor_across * std::pow(std::numbers::pi / 180.0, 2) /
                      (static_cast<double>(steps_in) * steps_across);
  const double root = std::sqrt(std::clamp(f0, 0.0, kHighestF0)), index = (1.0 + root) / (1.0 - root);
  double flux = 0.0;
  for (int i = 0; i < kSourceSteps; ++i) {
    for (int j = 0; j < kSourceSteps; ++j) {
      const Vec3 source = direction(angle_deg, middle(i, kSourceSteps, meter->source_in),
                                    middle(j, kSourceSteps, meter->source_across), -1.0);
      if (source.z() <= 0.0) continue;
      const Lobe lobe(normal, source, roughness);
      for (int k = 0; k < steps_in; ++k) {
        for (int l = 0; l < steps_across; ++l) {
          const Vec3 out = direction(angle_deg, middle(k, steps_in, meter->receptor_in),
                                     middle(l, steps_across, meter->receptor_across), 1.0);
          if (out.z() <= 0.0) continue;
          const Lobe::Value value = lobe.value(out);
          flux += value.shape * reflectance(index, value.half_cosine) * cell;
        }
      }
    }
  }
  // A perfect mirror's image lies wholly within the receptor: it reads its reflectance.
  flux /= kSourceSteps * kSourceSteps;
  return 100.0 * flux / reflectance(kGlassIndex, std::cos(angle_deg * std::numbers::pi / 180.0));
}

}  // namespace patinate::analysis
