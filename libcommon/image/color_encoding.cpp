#include "libcommon/image/color_encoding.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/image/color_matrix.h"
#include "patinate/image/color.h"

namespace patinate {

namespace {

constexpr std::array<double, 3> kD50{0.9642, 1.0, 0.8249};  ///< D50 as ICC profiles have it.

std::array<double, 3> white_of(const Chromaticities& c) {
  const double x = c.xy[3][0], y = c.xy[3][1];
  return {x / y, 1.0, (1.0 - x - y) / y};
}

/// XYZ from linear RGB.
ColorMatrix xyz_from_rgb(const Chromaticities& c) {
  ColorMatrix m{};
  for (std::size_t k = 0; k < 3; ++k) {
    m[0][k] = c.xy[k][0];
    m[1][k] = c.xy[k][1];
    m[2][k] = 1.0 - c.xy[k][0] - c.xy[k][1];
  }
  const std::array<double, 3> share = product(inverse(m), white_of(c));
  for (auto& row : m) {
    for (std::size_t k = 0; k < 3; ++k) row[k] *= share[k];
  }
  return m;
}

/// Linear Bradford adaptation of a white point to another.
ColorMatrix adaptation(const std::array<double, 3>& from, const std::array<double, 3>& to) {
  constexpr ColorMatrix kBradford{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
  const std::array<double, 3> a = product(kBradford, from), b = product(kBradford, to);
  ColorMatrix scaled = kBradford;
  for (std::size_t k = 0; k < 3; ++k) {
    for (double& v : scaled[k]) v *= b[k] / a[k];
  }
  return product(inverse(kBradford), scaled);
}

bool is_color_space(const Chromaticities& c) {
  for (const auto& [x, y] : c.xy) {
    if (!(std::abs(x) < 10.0 && std::abs(y) < 10.0)) return false;
  }
  constexpr double kLeast = 1e-4;
  const auto& [r, g, b, w] = c.xy;
  const double area = (g[0] - r[0]) * (b[1] - r[1]) - (g[1] - r[1]) * (b[0] - r[0]);
  if (!(w[1] > kLeast && std::abs(area) > kLeast)) return false;
  ColorMatrix m{};
  for (std::size_t k = 0; k < 3; ++k) m[0][k] = c.xy[k][0], m[1][k] = c.xy[k][1], m[2][k] = 1 - m[0][k] - m[1][k];
  const std::array<double, 3> share = product(inverse(m), white_of(c));
  return std::all_of(share.begin(), share.end(), [](double v) { return v > kLeast; });
}

ColorMatrix rec709_from(const Chromaticities& c) {
  return product(inverse(xyz_from_rgb(kRec709)), product(adaptation(white_of(c), white_of(kRec709)), xyz_from_rgb(c)));
}

/// Files round: chromaticities and profiles to four digits.
constexpr double kRounding = 1e-3;
bool is_identity(const ColorMatrix& m) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(std::abs(m[i][k] - (i == k ? 1.0 : 0.0)) < kRounding)) return false;
    }
  }
  return true;
}

/// A function of one value, each of few different ones computed once.
class CurveTable {
 public:
  explicit CurveTable(const ToneCurve& curve) : curve_(curve), entries_(kSteps + 1) {}
  float operator()(float code) {
    if (!(code >= 0.0f && code <= 1.0f)) return static_cast<float>(curve_(static_cast<double>(code)));
    // Any entry would do; lround is slower.
    Entry& entry = entries_[static_cast<std::size_t>(code * static_cast<float>(kSteps) +
                                                     0.5f)];  // NOLINT(bugprone-incorrect-roundings)
    if (entry.code != code) entry = {code, static_cast<float>(curve_(static_cast<double>(code)))};
    return entry.linear;
  }

 private:
  static constexpr int kSteps = 65535;
  struct Entry {
    float code = -1.0f, linear = 0.0f;
  };
  const ToneCurve& curve_;
  std::vector<Entry> entries_;
};

class CurvesAndMatrix final : public ColorEncoding {
 public:
  CurvesAndMatrix(ToneCurves curves, const ColorMatrix& matrix) : curves_(std::move(curves)), matrix_(matrix) {}

  void to_linear(ImageF& rgb) const override {
    std::vector<CurveTable> tables;
    for (const ToneCurve& curve : curves_) tables.emplace_back(curve);
    const bool is_same_space = is_identity(matrix_);
    float* pixel = rgb.data();
    for (std::int64_t i = 0; i < rgb.num_pixels(); ++i, pixel += 3) {
      std::array<double, 3> v{};
      for (std::size_t c = 0; c < 3; ++c) v[c] = static_cast<double>(curves_[c] ? tables[c](pixel[c]) : pixel[c]);
      if (!is_same_space) v = product(matrix_, v);
      for (std::size_t c = 0; c < 3; ++c) pixel[c] = static_cast<float>(v[c]);
    }
  }

 private:
  ToneCurves curves_;  ///< None: values are light.
  ColorMatrix matrix_;
};

double from_srgb(double code) { return static_cast<double>(linear_from_srgb(static_cast<float>(code))); }

/// Within half an 8-bit code of the sRGB curve everywhere.
bool is_srgb_curve(const ToneCurve& curve) {
  if (!curve) return false;
  for (int k = 0; k <= 255; ++k) {
    const double code = k / 255.0;
    const double again = static_cast<double>(srgb_from_linear(static_cast<float>(curve(code))));
    if (!(std::abs(again - code) < 0.5 / 255.0)) return false;
  }
  return true;
}

SaidColor of_primaries(std::string name, const Chromaticities& primaries, const ToneCurve& curve) {
  if (!is_color_space(primaries)) return {.name = "", .problem = "its chromaticities make no color space"};
  return color_of_curves(std::move(name), {curve, curve, curve}, rec709_from(primaries));
}

}  // namespace

SaidColor color_of_curves(std::string name, const ToneCurves& curves, const ColorMatrix& rec709) {
  const bool is_plain = std::all_of(curves.begin(), curves.end(), [](const ToneCurve& c) { return !c; }) ||
                        std::all_of(curves.begin(), curves.end(), is_srgb_curve);
  if (is_plain && is_identity(rec709)) return {.name = std::move(name)};
  return {.name = std::move(name), .encoding = std::make_shared<CurvesAndMatrix>(curves, rec709)};
}

ColorMatrix rec709_from_d50() { return product(inverse(xyz_from_rgb(kRec709)), adaptation(kD50, white_of(kRec709))); }

SaidColor color_of_primaries(std::string name, const Chromaticities& primaries, double gamma) {
  return of_primaries(std::move(name), primaries,
                      [gamma](double code) { return std::pow(std::max(0.0, code), gamma); });
}

SaidColor light_of_primaries(std::string name, const Chromaticities& primaries) {
  return of_primaries(std::move(name), primaries, {});
}

SaidColor srgb_color_of_primaries(std::string name, const Chromaticities& primaries) {
  return of_primaries(std::move(name), primaries, from_srgb);
}

namespace {

struct NamedPrimaries {
  const char* name;
  Chromaticities at;
};

/// [ITU-T H.273, table 2].
const NamedPrimaries* primaries_of_code(int code) {
  static const std::map<int, NamedPrimaries> kKnown{
      {1, {"Rec. 709", kRec709}},
      {4, {"BT.470 M", {{{{0.67, 0.33}, {0.21, 0.71}, {0.14, 0.08}, {0.310, 0.316}}}}}},
      {5, {"BT.601 (625)", {{{{0.64, 0.33}, {0.29, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}}}}}},
      {6, {"BT.601 (525)", {{{{0.630, 0.340}, {0.310, 0.595}, {0.155, 0.070}, {0.3127, 0.3290}}}}}},
      {7, {"SMPTE 240M", {{{{0.630, 0.340}, {0.310, 0.595}, {0.155, 0.070}, {0.3127, 0.3290}}}}}},
      {9, {"BT.2020", {{{{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}}}}}},
      {11, {"DCI-P3", {{{{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.314, 0.351}}}}}},
      {12, {"Display P3", {{{{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.3127, 0.3290}}}}}}};
  const auto found = kKnown.find(code);
  return found == kKnown.end() ? nullptr : &found->second;
}

}  // namespace

std::string primaries_name(const Chromaticities& primaries) {
  constexpr double kNear = 0.0015;
  const auto is_same = [&](const Chromaticities& known, std::size_t count = 4) {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < 2; ++k) {
        if (!(std::abs(primaries.xy[i][k] - known.xy[i][k]) < kNear)) return false;
      }
    }
    return true;
  };
  static const std::array<NamedPrimaries, 4> kOthers{
      {{"Adobe RGB", kAdobeRgb},
       {"ProPhoto RGB", {{{{0.7347, 0.2653}, {0.1596, 0.8404}, {0.0366, 0.0001}, {0.3457, 0.3585}}}}},
       {"ACES2065-1", {{{{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.077}, {0.32168, 0.33767}}}}},
       {"ACEScg", {{{{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}}}}}}};
  for (const int code : {1, 9, 12, 11, 4, 5, 6}) {
    if (is_same(primaries_of_code(code)->at)) return primaries_of_code(code)->name;
  }
  const auto found =
      std::find_if(kOthers.begin(), kOthers.end(), [&](const NamedPrimaries& p) { return is_same(p.at); });
  if (found != kOthers.end()) return found->name;
  constexpr Chromaticities kXyz{{{{1.0, 0.0}, {0.0, 1.0}, {0.0, 0.0}, {1.0 / 3.0, 1.0 / 3.0}}}};
  const auto text = [](double v) { return short_number_text(std::round(1e4 * v) / 1e4); };
  const std::string white = "white " + text(primaries.xy[3][0]) + ", " + text(primaries.xy[3][1]);
  return (is_same(kXyz, 3) ? "CIE XYZ, " : "primaries of its own, ") + white;
}

namespace {

/// Camera curve of BT.709 [ITU-R BT.709, 1.2], as light from a code.
double from_bt709(double v) { return v < 0.081 ? v / 4.5 : std::pow((v + 0.099) / 1.099, 1.0 / 0.45); }
/// [SMPTE ST 2084], 1 at 203 cd/m2.
double from_pq(double v) {
  constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 4096 * 128, kC1 = 3424.0 / 4096, kC2 = 2413.0 / 4096 * 32,
                   kC3 = 2392.0 / 4096 * 32, kPeak = 10000.0, kWhite = 203.0;
  const double p = std::pow(std::clamp(v, 0.0, 1.0), 1.0 / kM2);
  return kPeak / kWhite * std::pow(std::max(0.0, p - kC1) / (kC2 - kC3 * p), 1.0 / kM1);
}
/// Scene light of [ITU-R BT.2100], 1 at 75 %.
double from_hlg(double v) {
  constexpr double kA = 0.17883277, kB = 1.0 - 4.0 * kA, kWhite = 0.75;
  const double c = 0.5 - kA * std::log(4.0 * kA);
  const auto light = [&](double e) { return e <= 0.5 ? e * e / 3.0 : (std::exp((e - c) / kA) + kB) / 12.0; };
  return light(std::clamp(v, 0.0, 1.0)) / light(kWhite);
}

struct NamedCurve {
  const char* name;
  ToneCurve curve;
};

/// [ITU-T H.273, table 3].
std::optional<NamedCurve> curve_of_code(int code) {
  const auto power = [](double gamma) { return [gamma](double v) { return std::pow(std::max(0.0, v), gamma); }; };
  switch (code) {
    case 1:
    case 6:
    case 14:
    case 15:
      return NamedCurve{"BT.709 curve", from_bt709};
    case 4:
      return NamedCurve{"gamma 2.2", power(2.2)};
    case 5:
      return NamedCurve{"gamma 2.8", power(2.8)};
    case 8:
      return NamedCurve{"linear", [](double v) { return v; }};
    case 2:  // Not specified.
    case 13:
      return NamedCurve{"sRGB curve", from_srgb};
    case 16:
      return NamedCurve{"PQ", from_pq};
    case 18:
      return NamedCurve{"HLG", from_hlg};
    default:
      return std::nullopt;
  }
}

}  // namespace

SaidColor color_of_code_points(int primaries, int transfer, bool is_full_range) {
  constexpr int kUnspecified = 2, kFirst = 1;
  const NamedPrimaries* space = primaries_of_code(primaries == kUnspecified ? kFirst : primaries);
  std::optional<NamedCurve> curve = curve_of_code(transfer);
  if (space == nullptr || !curve)
    return {.name = "",
            .problem = "its color code points (primaries " + std::to_string(primaries) + ", transfer " +
                       std::to_string(transfer) + ") are not known"};
  std::string name = std::string(space->name) + ", " + curve->name;
  if (std::string_view(curve->name) == "PQ" || std::string_view(curve->name) == "HLG")
    name += ", 1 is its reference white";
  if (!is_full_range) {
    name += ", narrow range";
    curve->curve = [inner = curve->curve](double v) { return inner((255.0 * v - 16.0) / 219.0); };
  }
  return of_primaries(std::move(name), space->at, curve->curve);
}

ImageF linear_from_lab(const ImageF& lab, const std::array<double, 2>& white) {
  Chromaticities space = kRec709;
  space.xy[3] = white;
  const std::array<double, 3> from_white = white_of(space);
  const ColorMatrix rec709 = product(inverse(xyz_from_rgb(kRec709)), adaptation(from_white, white_of(kRec709)));
  constexpr double kEdge = 6.0 / 29.0;
  const auto f = [](double t) { return t > kEdge ? t * t * t : 3.0 * kEdge * kEdge * (t - 4.0 / 29.0); };
  ImageF rgb(lab.width(), lab.height(), 3);
  for (std::int64_t i = 0; i < lab.num_pixels(); ++i) {
    const float* from = lab.data() + 3 * i;
    const double y = (static_cast<double>(from[0]) + 16.0) / 116.0;
    const std::array<double, 3> xyz{from_white[0] * f(y + static_cast<double>(from[1]) / 500.0), from_white[1] * f(y),
                                    from_white[2] * f(y - static_cast<double>(from[2]) / 200.0)};
    const std::array<double, 3> linear = product(rec709, xyz);
    for (std::size_t c = 0; c < 3; ++c)
      rgb.data()[3 * i + static_cast<std::int64_t>(c)] = static_cast<float>(linear[c]);
  }
  return rgb;
}

}  // namespace patinate
