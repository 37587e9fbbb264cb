#include <lcms2.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "libcommon/image/color_encoding.h"
#include "libcommon/image/color_matrix.h"

namespace patinate {

namespace {

using Profile = std::unique_ptr<void, decltype(&cmsCloseProfile)>;
using Transform = std::unique_ptr<void, decltype(&cmsDeleteTransform)>;

constexpr std::size_t kLargestProfile = std::size_t{64} << 20;

Profile open_profile(const std::string& bytes) {
  const bool has_size = bytes.size() <= kLargestProfile;
  return {has_size ? cmsOpenProfileFromMem(bytes.data(), static_cast<cmsUInt32Number>(bytes.size())) : nullptr,
          &cmsCloseProfile};
}

/// "Display P3 (ICC profile)". A name is another's text: one short line of it.
std::string name_of_profile(cmsHPROFILE profile) {
  std::array<char, 128> text{};
  (void)cmsGetProfileInfoASCII(profile, cmsInfoDescription, "en", "US", text.data(), text.size() - 1);
  std::string name = text.data();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }, ' ');
  return name.empty() ? "unnamed (ICC profile)" : name + " (ICC profile)";
}

/// XYZ (D50) as lcms hands it out becomes our light.
void rec709_from_xyz(const std::vector<float>& xyz, float* rgb) {
  static const ColorMatrix kMatrix = rec709_from_d50();
  for (std::size_t i = 0; i < xyz.size(); i += 3) {
    const std::array<double, 3> v =
        product(kMatrix, std::array<double, 3>{static_cast<double>(xyz[i]), static_cast<double>(xyz[i + 1]),
                                               static_cast<double>(xyz[i + 2])});
    for (std::size_t c = 0; c < 3; ++c) rgb[i + c] = static_cast<float>(v[c]);
  }
}

/// A profile's tables, by lcms. One row at a time, so that memory stays small.
class TableTransform {
 public:
  TableTransform(cmsHPROFILE profile, cmsUInt32Number format) : transform_(nullptr, &cmsDeleteTransform) {
    const Profile xyz(cmsCreateXYZProfile(), &cmsCloseProfile);
    constexpr cmsUInt32Number kXyzFloat = FLOAT_SH(1) | COLORSPACE_SH(PT_XYZ) | CHANNELS_SH(3) | BYTES_SH(4);
    transform_.reset(cmsCreateTransform(profile, format, xyz.get(), kXyzFloat, INTENT_RELATIVE_COLORIMETRIC,
                                        cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE));
  }
  [[nodiscard]] bool is_usable() const { return transform_ != nullptr; }
  void run(const float* from, int num_pixels, float* rgb) const {
    std::vector<float> xyz(3 * static_cast<std::size_t>(num_pixels));
    cmsDoTransform(transform_.get(), from, xyz.data(), static_cast<cmsUInt32Number>(num_pixels));
    rec709_from_xyz(xyz, rgb);
  }

 private:
  Transform transform_;
};

class RgbTables final : public ColorEncoding {
 public:
  explicit RgbTables(cmsHPROFILE profile) : tables_(profile, TYPE_RGB_FLT) {}
  [[nodiscard]] bool is_usable() const { return tables_.is_usable(); }
  void to_linear(ImageF& rgb) const override {
    for (int y = 0; y < rgb.height(); ++y) {
      float* row = rgb.data() + 3 * static_cast<std::int64_t>(y) * rgb.width();
      const std::vector<float> codes(row, row + 3 * static_cast<std::int64_t>(rgb.width()));
      tables_.run(codes.data(), rgb.width(), row);
    }
  }

 private:
  TableTransform tables_;
};

class CmykTables final : public InkEncoding {
 public:
  explicit CmykTables(cmsHPROFILE profile) : tables_(profile, TYPE_CMYK_FLT) {}
  [[nodiscard]] bool is_usable() const { return tables_.is_usable(); }
  [[nodiscard]] ImageF to_linear(const ImageF& cmyk) const override {
    ImageF rgb(cmyk.width(), cmyk.height(), 3);
    std::vector<float> inks(4 * static_cast<std::size_t>(cmyk.width()));
    for (int y = 0; y < cmyk.height(); ++y) {
      const float* from = cmyk.data() + 4 * static_cast<std::int64_t>(y) * cmyk.width();
      // lcms has inks in percent.
      std::transform(from, from + inks.size(), inks.begin(), [](float v) { return 100.0f * v; });
      tables_.run(inks.data(), cmyk.width(), rgb.data() + 3 * static_cast<std::int64_t>(y) * rgb.width());
    }
    return rgb;
  }

 private:
  TableTransform tables_;
};

/// The curve of a tag, its own copy.
ToneCurve curve_of_tag(cmsHPROFILE profile, cmsTagSignature tag) {
  const auto* given = static_cast<const cmsToneCurve*>(cmsReadTag(profile, tag));
  if (given == nullptr) return {};
  const std::shared_ptr<cmsToneCurve> curve(cmsDupToneCurve(given), &cmsFreeToneCurve);
  if (curve == nullptr) return {};
  return [curve](double v) {
    return static_cast<double>(cmsEvalToneCurveFloat(curve.get(), static_cast<float>(std::clamp(v, 0.0, 1.0))));
  };
}

/// Nothing if the profile is of tables, or wanting.
std::optional<SaidColor> color_of_matrix(cmsHPROFILE profile, const std::string& name) {
  if (cmsIsTag(profile, cmsSigAToB0Tag) || cmsIsTag(profile, cmsSigAToB1Tag) || !cmsIsMatrixShaper(profile)) return {};
  constexpr std::array kColorants{cmsSigRedColorantTag, cmsSigGreenColorantTag, cmsSigBlueColorantTag};
  constexpr std::array kCurves{cmsSigRedTRCTag, cmsSigGreenTRCTag, cmsSigBlueTRCTag};
  ColorMatrix xyz{};
  ToneCurves curves;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto* colorant = static_cast<const cmsCIEXYZ*>(cmsReadTag(profile, kColorants[k]));
    curves[k] = curve_of_tag(profile, kCurves[k]);
    if (colorant == nullptr || !curves[k]) return {};
    xyz[0][k] = colorant->X;
    xyz[1][k] = colorant->Y;
    xyz[2][k] = colorant->Z;
  }
  return color_of_curves(name, curves, product(rec709_from_d50(), xyz));
}

SaidColor color_of_rgb(cmsHPROFILE profile, const std::string& name) {
  if (auto color = color_of_matrix(profile, name)) return *std::move(color);
  auto tables = std::make_shared<RgbTables>(profile);
  if (!tables->is_usable()) return {.name = "", .problem = "its ICC profile lacks what colors need"};
  return {.name = name, .encoding = std::move(tables)};
}

SaidColor color_of_gray(cmsHPROFILE profile, const std::string& name) {
  const ToneCurve curve = curve_of_tag(profile, cmsSigGrayTRCTag);
  if (!curve) return {.name = "", .problem = "its ICC profile lacks what gray needs"};
  constexpr ColorMatrix kSame{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  return color_of_curves(name, {curve, curve, curve}, kSame);
}

constexpr const char* kDamaged = "its ICC profile is damaged";

}  // namespace

SaidColor color_of_profile(const std::string& bytes, int channels) {
  const Profile profile = open_profile(bytes);
  if (profile == nullptr) return {.name = "", .problem = kDamaged};
  const std::string name = name_of_profile(profile.get());
  const cmsColorSpaceSignature space = cmsGetColorSpace(profile.get());
  if (cmsGetDeviceClass(profile.get()) == cmsSigLinkClass || cmsGetDeviceClass(profile.get()) == cmsSigNamedColorClass)
    return {.name = "", .problem = "its profile " + name + " is of a kind that describes no picture"};
  if (space == cmsSigRgbData && channels == 3) return color_of_rgb(profile.get(), name);
  if (space == cmsSigGrayData && channels == 1) return color_of_gray(profile.get(), name);
  return {.name = "", .problem = "its profile " + name + " is of another kind of color than its pixels"};
}

InkColor color_of_cmyk_profile(const std::string& bytes) {
  if (bytes.empty()) return {.name = ""};
  const Profile profile = open_profile(bytes);
  if (profile == nullptr) return {.name = "", .problem = kDamaged};
  const std::string name = name_of_profile(profile.get());
  if (cmsGetColorSpace(profile.get()) != cmsSigCmykData)
    return {.name = "", .problem = "its profile " + name + " is of another kind of color than its pixels"};
  auto tables = std::make_shared<CmykTables>(profile.get());
  if (!tables->is_usable()) return {.name = "", .problem = "its ICC profile lacks what colors need"};
  return {.name = name, .encoding = std::move(tables)};
}

}  // namespace patinate
