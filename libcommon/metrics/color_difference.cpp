#include <algorithm>
#include <cmath>
#include <numbers>

#include "patinate/metrics/difference.h"

namespace patinate {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

double cos_deg(double degrees) { return std::cos(degrees / kDegrees); }

/// Hue angle in [0, 360); 0 for gray.
double hue_deg(double a, double b) {
  if (a == 0.0 && b == 0.0) return 0.0;
  const double h = std::atan2(b, a) * kDegrees;
  return h < 0.0 ? h + 360.0 : h;
}

double seventh_power_share(double chroma) {
  const double c7 = std::pow(chroma, 7.0);
  return std::sqrt(c7 / (c7 + 6103515625.0));  // 25^7
}

}  // namespace

double ciede2000(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  if (a == b) return 0.0;
  // Equations 2 to 7: a' stretches the reddish-greenish axis near gray.
  const double mean_c = (std::hypot(a[1], a[2]) + std::hypot(b[1], b[2])) / 2.0;
  const double G = 0.5 * (1.0 - seventh_power_share(mean_c));
  const double a1 = (1.0 + G) * a[1], a2 = (1.0 + G) * b[1];
  const double C1 = std::hypot(a1, a[2]), C2 = std::hypot(a2, b[2]);
  const double h1 = hue_deg(a1, a[2]), h2 = hue_deg(a2, b[2]);
  // Equations 8 to 11.
  const bool is_gray = C1 * C2 == 0.0;
  double dh = is_gray ? 0.0 : h2 - h1;
  if (dh > 180.0) dh -= 360.0;
  if (dh < -180.0) dh += 360.0;
  const double dL = b[0] - a[0], dC = C2 - C1;
  const double dH = 2.0 * std::sqrt(C1 * C2) * std::sin(dh / 2.0 / kDegrees);
  // Equations 12 to 22.
  const double L = (a[0] + b[0]) / 2.0, C = (C1 + C2) / 2.0;
  double h = h1 + h2;
  if (!is_gray) {
    if (std::abs(h1 - h2) > 180.0) h += h < 360.0 ? 360.0 : -360.0;
    h /= 2.0;
  }
  const double T = 1.0 - 0.17 * cos_deg(h - 30.0) + 0.24 * cos_deg(2.0 * h) + 0.32 * cos_deg(3.0 * h + 6.0) -
                   0.20 * cos_deg(4.0 * h - 63.0);
  const double turn = 30.0 * std::exp(-((h - 275.0) / 25.0) * ((h - 275.0) / 25.0));
  const double dl = (L - 50.0) * (L - 50.0);
  const double SL = 1.0 + 0.015 * dl / std::sqrt(20.0 + dl), SC = 1.0 + 0.045 * C, SH = 1.0 + 0.015 * C * T;
  const double RT = -std::sin(2.0 * turn / kDegrees) * 2.0 * seventh_power_share(C);
  const double l = dL / SL, c = dC / SC, e = dH / SH;
  return std::sqrt(std::max(0.0, l * l + c * c + e * e + RT * c * e));
}

std::array<double, 3> linear_from_lab(const std::array<double, 3>& lab) {
  const double fy = (lab[0] + 16.0) / 116.0, f[3] = {fy + lab[1] / 500.0, fy, fy - lab[2] / 200.0};
  constexpr double kWhite[3] = {0.4124564 + 0.3575761 + 0.1804375, 0.2126729 + 0.7151522 + 0.0721750,
                                0.0193339 + 0.1191920 + 0.9503041};
  double xyz[3];
  for (int i = 0; i < 3; ++i)
    xyz[i] = kWhite[i] * (f[i] > 6.0 / 29.0 ? f[i] * f[i] * f[i] : (116.0 * f[i] - 16.0) * 27.0 / 24389.0);
  // Inverse of the matrix of lab_from_linear().
  constexpr double kRgb[3][3] = {{3.2404541621141054, -1.5371385127977166, -0.4985314095560162},
                                 {-0.9692660305051868, 1.8760108454466942, 0.0415560175303498},
                                 {0.0556434309591147, -0.2040259135167538, 1.0572251882231791}};
  std::array<double, 3> rgb{};
  for (std::size_t i = 0; i < 3; ++i) rgb[i] = kRgb[i][0] * xyz[0] + kRgb[i][1] * xyz[1] + kRgb[i][2] * xyz[2];
  return rgb;
}

}  // namespace patinate
