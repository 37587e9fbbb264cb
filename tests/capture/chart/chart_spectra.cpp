#include "tests/capture/chart/chart_spectra.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace patinate::testing_support {

namespace {

double wavelength_nm(int band) { return 390.0 + 10.0 * band; }

Spectrum bell(double peak_nm, double below_nm, double above_nm) {
  Spectrum s;
  for (int i = 0; i < kNumBands; ++i) {
    const double t = (wavelength_nm(i) - peak_nm) / (wavelength_nm(i) < peak_nm ? below_nm : above_nm);
    s[i] = std::exp(-0.5 * t * t);
  }
  return s;
}

std::array<Spectrum, 3> eye() {
  return {1.056 * bell(599.8, 37.9, 31.0) + 0.362 * bell(442.0, 16.0, 26.7) - 0.065 * bell(501.1, 20.4, 26.2),
          0.821 * bell(568.8, 46.9, 40.5) + 0.286 * bell(530.9, 16.3, 31.1),
          1.217 * bell(437.0, 11.8, 36.0) + 0.681 * bell(459.0, 26.0, 13.8)};
}

Spectrum black_body(double kelvin) {
  Spectrum s;
  for (int i = 0; i < kNumBands; ++i) {
    const double meters = 1e-9 * wavelength_nm(i);
    s[i] = 1.0 / (std::pow(meters / 5.6e-7, 5.0) * std::expm1(1.438777e-2 / (meters * kelvin)));
  }
  return s / s.maxCoeff();
}

double cube_root_of(double t) { return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0; }

Spectrum sigmoid(const Eigen::Vector3d& c) {
  Spectrum s;
  for (int i = 0; i < kNumBands; ++i) {
    const double t = (wavelength_nm(i) - 550.0) / 150.0, x = c[0] + t * (c[1] + t * c[2]);
    s[i] = 0.5 + x / (2.0 * std::sqrt(1.0 + x * x));
  }
  return s;
}

}  // namespace

Eigen::Vector3d relative_xyz(const Spectrum& reflectance) {
  static const Spectrum white = black_body(6504.0);
  static const std::array<Spectrum, 3> seen = eye();
  Eigen::Vector3d xyz;
  for (int c = 0; c < 3; ++c)
    xyz[c] = (reflectance * white * seen[static_cast<std::size_t>(c)]).sum() /
             (white * seen[static_cast<std::size_t>(c)]).sum();
  return xyz;
}

std::array<double, 3> lab_of_surface(const Spectrum& reflectance) {
  const Eigen::Vector3d xyz = relative_xyz(reflectance);
  const double fx = cube_root_of(xyz[0]), fy = cube_root_of(xyz[1]), fz = cube_root_of(xyz[2]);
  return {116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)};
}

Spectrum surface_of_lab(const std::array<double, 3>& lab) {
  const Eigen::Vector3d wanted(lab[0], lab[1], lab[2]);
  const auto error_of = [&](const Eigen::Vector3d& c) {
    const std::array<double, 3> found = lab_of_surface(sigmoid(c));
    return Eigen::Vector3d(Eigen::Vector3d(found.data()) - wanted);
  };
  Eigen::Vector3d c(0.0, 0.0, 0.0);
  double damping = 1e-2;
  Eigen::Vector3d error = error_of(c);
  for (int i = 0; i < 200 && error.norm() > 1e-6; ++i) {  // Levenberg and Marquardt.
    Eigen::Matrix3d slopes;
    for (int k = 0; k < 3; ++k) {
      constexpr double kStep = 1e-5;
      Eigen::Vector3d moved = c;
      moved[k] += kStep;
      slopes.col(k) = (error_of(moved) - error) / kStep;
    }
    Eigen::Matrix3d normal = slopes.transpose() * slopes;
    normal.diagonal() *= 1.0 + damping;
    const Eigen::Vector3d next = c - normal.ldlt().solve(slopes.transpose() * error);
    const Eigen::Vector3d next_error = error_of(next);
    const bool is_better = next_error.norm() < error.norm();
    damping *= is_better ? 0.3 : 5.0;
    if (!is_better) continue;
    c = next;
    error = next_error;
  }
  return sigmoid(c);
}

Spectrum rippled(const Spectrum& reflectance, double size, double phase) {
  Spectrum s = reflectance;
  for (int i = 0; i < kNumBands; ++i) {
    const double wave = std::sin(phase + 2.0 * std::numbers::pi * (wavelength_nm(i) - 390.0) / 120.0);
    s[i] *= 1.0 + size * wave * (1.0 - s[i]);
  }
  return s.max(0.0).min(1.0);
}

Spectrum lamp_spectrum(int lamp) {
  if (lamp == 0) return black_body(5000.0);
  if (lamp == 1) return black_body(2856.0);
  return 0.8 * bell(452.0, 11.0, 13.0) + 0.9 * bell(560.0, 45.0, 65.0) + 0.25 * bell(640.0, 50.0, 45.0);
}

std::array<Spectrum, 3> camera_spectra(int camera) {
  const std::array<Spectrum, 3> xyz = eye();
  if (camera == 0)
    return {1.2 * xyz[0] + 0.1 * xyz[1] - 0.15 * xyz[2], -0.4 * xyz[0] + 1.3 * xyz[1] + 0.05 * xyz[2], 0.9 * xyz[2]};
  if (camera == 1) return {bell(598.0, 33.0, 35.0), bell(540.0, 38.0, 40.0), bell(455.0, 25.0, 32.0)};
  return {bell(595.0, 28.0, 42.0) + 0.06 * bell(430.0, 20.0, 20.0), bell(530.0, 36.0, 45.0), bell(460.0, 28.0, 28.0)};
}

}  // namespace patinate::testing_support
