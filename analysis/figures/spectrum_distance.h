/// \file
/// How far two power spectra are apart.
#pragma once

#include <optional>
#include <vector>

namespace patinate::analysis {

/// Power over frequencies that are half an octave apart, as SpatialStructure gives them; both lists may be empty.
struct Spectrum {
  std::vector<double> frequencies;  ///< Cycles per pixel, ascending.
  std::vector<double> power;        ///< Power of each frequency, >= 0.
};

/// log2 of a spectrum at a frequency between its rings. @returns nothing outside of them.
[[nodiscard]] std::optional<double> log_power(const Spectrum& spectrum, double frequency);

/// Octaves by which two spectra differ, mean over the frequencies that both have, of which there must be `least_rings`.
/// @param pixel_a,pixel_b  Surface length of a pixel, in one unit.
[[nodiscard]] std::optional<double> octaves_between(const Spectrum& a, double pixel_a, const Spectrum& b,
                                                    double pixel_b, int least_rings = 1);

/// How differently lightness varies at each wavelength, L*: the root of the summed squared differences between the
/// standard deviations of its half octaves, over the frequencies that both have. A half octave around f cycles per
/// pixel is pi f^2 / sqrt(2) of the plane of frequencies, so its variance is that times the power. A surface without
/// any structure is as far as the other one varies. @returns nothing where they share no frequency.
[[nodiscard]] std::optional<double> contrast_between(const Spectrum& a, double pixel_a, const Spectrum& b,
                                                     double pixel_b);

}  // namespace patinate::analysis
