#include "libcommon/history/appearance.h"

#include <algorithm>
#include <cmath>

#include "patinate/history/history_sampling.h"
#include "patinate/image/color.h"

namespace patinate {

namespace {

using Color = std::array<double, 3>;

/// A squared distance of two colors below which they are one: half a code of 8 bits.
constexpr double kOneColor = 0.25 / (255.0 * 255.0);

Color code_of(const Color& linear) {
  Color code;
  for (std::size_t c = 0; c < 3; ++c)
    code[c] = static_cast<double>(srgb_from_linear(static_cast<float>(std::clamp(linear[c], 0.0, 1.0))));
  return code;
}

double luminance_of(const Color& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/// A number at every pixel.
class Field {
 public:
  Field(const StatedValue& value, const AppearanceSources& sources, double time)
      : curve_(value.curve), constant_(value.by == StatedValue::By::Time ? curve_.at(time) : curve_.points.front()[1]) {
    if (value.by == StatedValue::By::Control) image_ = &sources.controls.at(value.control);
    if (value.by == StatedValue::By::Mask) image_ = &sources.masks.at(value.mask);
  }
  [[nodiscard]] double at(std::int64_t pixel) const {
    return image_ == nullptr ? constant_ : curve_.at(static_cast<double>(image_->data()[pixel]));
  }

 private:
  const ValueCurve& curve_;
  double constant_;
  const ImageF* image_ = nullptr;
};

/// Numbers of a pixel, all of them known.
struct PixelMaterial {
  double metalness = 0.0;
  double roughness = static_cast<double>(kUnknownRoughness);
  double specular = static_cast<double>(kUnknownSpecular);
  Color tint{1.0, 1.0, 1.0};
};

double roughness_of(const StatedMaterial& m) { return m.roughness.value_or(static_cast<double>(kUnknownRoughness)); }
double specular_of(const StatedMaterial& m) { return m.specular.value_or(static_cast<double>(kUnknownSpecular)); }

/// Materials as pixels are compared with them.
class Palette {
 public:
  explicit Palette(const std::vector<StatedMaterial>& materials) : materials_(materials), shares_(materials.size()) {
    for (const StatedMaterial& m : materials) codes_.push_back(code_of(m.color));
  }

  [[nodiscard]] PixelMaterial at(const Color& pixel) {
    find_shares(code_of(pixel));
    PixelMaterial out{.metalness = 0.0, .roughness = 0.0, .specular = 0.0, .tint = {}};
    double reflected = 0.0;
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      const StatedMaterial& m = materials_[i];
      out.metalness += shares_[i] * m.metalness;
      out.roughness += shares_[i] * roughness_of(m);
      out.specular += shares_[i] * specular_of(m);
      const double reflects = shares_[i] * (m.metalness + (1.0 - m.metalness) * specular_of(m));
      const Color tint = tint_of(m, pixel);
      for (std::size_t c = 0; c < 3; ++c) out.tint[c] += reflects * tint[c];
      reflected += reflects;
    }
    for (double& t : out.tint) t = reflected > 0.0 ? t / reflected : 1.0;
    return out;
  }

 private:
  void find_shares(const Color& code) {
    double sum = 0.0;
    for (std::size_t i = 0; i < codes_.size(); ++i) {
      double d2 = kOneColor;
      for (std::size_t c = 0; c < 3; ++c) d2 += (code[c] - codes_[i][c]) * (code[c] - codes_[i][c]);
      shares_[i] = 1.0 / (d2 * d2);
      sum += shares_[i];
    }
    for (double& share : shares_) share /= sum;
  }

  static Color tint_of(const StatedMaterial& m, const Color& pixel) {
    if (!m.tint) {
      Color own;
      for (std::size_t c = 0; c < 3; ++c) own[c] = 1.0 + m.metalness * (std::clamp(pixel[c], 0.0, 1.0) - 1.0);
      return own;
    }
    const double seen = luminance_of(m.color), brightest = std::max({(*m.tint)[0], (*m.tint)[1], (*m.tint)[2]});
    if (!(seen > 0.0 && brightest > 0.0)) return *m.tint;
    const double level = std::clamp(luminance_of(pixel) / seen, 0.0, 1.0 / brightest);
    Color tint = *m.tint;
    for (double& t : tint) t *= 1.0 + m.metalness * (level - 1.0);
    return tint;
  }

  const std::vector<StatedMaterial>& materials_;
  std::vector<Color> codes_;
  std::vector<double> shares_;
};

bool has_tints(const Appearance& a) {
  return a.tint || std::any_of(a.materials.begin(), a.materials.end(),
                               [](const StatedMaterial& m) { return m.tint.has_value(); });
}

bool has_mirrors(const Appearance& a) {
  return a.roughness || a.specular || std::any_of(a.materials.begin(), a.materials.end(), [](const StatedMaterial& m) {
           return m.roughness || m.specular;
         });
}

float in_unit(double v) { return static_cast<float>(std::clamp(v, 0.0, 1.0)); }

}  // namespace

double ValueCurve::at(double x) const {
  const auto next = std::upper_bound(points.begin(), points.end(), x,
                                     [](double value, const std::array<double, 2>& p) { return value < p[0]; });
  if (next == points.begin()) return points.front()[1];
  if (next == points.end()) return points.back()[1];
  const auto& a = *(next - 1);
  return a[1] + (x - a[0]) / ((*next)[0] - a[0]) * ((*next)[1] - a[1]);
}

bool Appearance::is_empty() const { return !metalness && !roughness && !specular && !tint && materials.empty(); }

bool Appearance::has_course() const {
  const auto is_timed = [](const std::optional<StatedValue>& v) { return v && v->by == StatedValue::By::Time; };
  return !materials.empty() || is_timed(metalness) || is_timed(roughness) || is_timed(specular);
}

std::vector<std::string> Appearance::map_names() const {
  std::vector<std::string> names;
  if (has_mirrors(*this)) names.emplace_back("specular");
  if (metalness || !materials.empty()) names.emplace_back("metalness");
  if (has_tints(*this)) names.emplace_back("tint");
  return names;
}

const ImageF& AppearanceMaps::of(const std::string& name) const {
  return name == "metalness" ? metalness : name == "tint" ? tint : specular;
}

AppearanceMaps appearance_maps(const Appearance& appearance, const AppearanceSources& sources, double time,
                               const ImageF& color) {
  AppearanceMaps maps;
  const std::vector<std::string> names = appearance.map_names();
  const auto make = [&](const char* name, int channels) {
    return std::find(names.begin(), names.end(), name) != names.end() ? ImageF(color.width(), color.height(), channels)
                                                                      : ImageF();
  };
  maps.metalness = make("metalness", 1);
  maps.specular = make("specular", 2);
  maps.tint = make("tint", 3);
  const auto field = [&](const std::optional<StatedValue>& value) {
    return value ? std::optional<Field>(std::in_place, *value, sources, time) : std::nullopt;
  };
  const auto metalness = field(appearance.metalness), roughness = field(appearance.roughness),
             specular = field(appearance.specular);
  Palette palette(appearance.materials);
  for (std::int64_t i = 0; i < color.num_pixels(); ++i) {
    PixelMaterial m;
    if (!appearance.materials.empty()) {
      const float* p = color.data() + 3 * i;
      m = palette.at({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    }
    if (metalness) m.metalness = metalness->at(i);
    if (roughness) m.roughness = roughness->at(i);
    if (specular) m.specular = specular->at(i);
    if (appearance.tint) m.tint = *appearance.tint;
    if (!maps.metalness.empty()) maps.metalness.data()[i] = in_unit(m.metalness);
    if (!maps.specular.empty()) {
      maps.specular.data()[2 * i] = in_unit(m.specular);
      maps.specular.data()[2 * i + 1] = in_unit(m.roughness);
    }
    for (std::size_t c = 0; !maps.tint.empty() && c < 3; ++c)
      maps.tint.data()[3 * i + static_cast<std::int64_t>(c)] = in_unit(m.tint[c]);
  }
  return maps;
}

}  // namespace patinate
