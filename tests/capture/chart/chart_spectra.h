/// \file
/// Spectra as formulas: what the eye, lamps and cameras see of surfaces. For tests of charts.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace patinate::testing_support {

inline constexpr int kNumBands = 33;  ///< 390 to 710 nm by 10.
using Spectrum = Eigen::Array<double, kNumBands, 1>;

/// XYZ of a surface under what stands for D65 (a black body of 6504 K), relative to that of white; the eye by [Wyman,
/// Sloan, Shirley 2013].
[[nodiscard]] Eigen::Vector3d relative_xyz(const Spectrum& reflectance);
/// CIELAB of it.
[[nodiscard]] std::array<double, 3> lab_of_surface(const Spectrum& reflectance);
/// A smooth surface of that color [Jakob, Hanika 2019]: a sigmoid of a parabola over the wavelength.
[[nodiscard]] Spectrum surface_of_lab(const std::array<double, 3>& lab);
/// Spectrum with a ripple over the wavelength: of another family than the chart's patches.
[[nodiscard]] Spectrum rippled(const Spectrum& reflectance, double size, double phase);

/// @param lamp  As ChartScene has it.
[[nodiscard]] Spectrum lamp_spectrum(int lamp);
/// Sensitivities of red, green and blue. Camera 0's are mixtures of the eye's; the others' are not.
[[nodiscard]] std::array<Spectrum, 3> camera_spectra(int camera);

}  // namespace patinate::testing_support
