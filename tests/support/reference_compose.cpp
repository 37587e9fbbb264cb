#include "tests/support/reference_compose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "patinate/image/color.h"
#include "simulation/composition/grain.h"
#include "simulation/composition/height_frames.h"
#include "simulation/composition/laid_picture.h"
#include "simulation/composition/quantized_appearance.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation {

namespace {

constexpr double kMostWeight = 65535.0 / 16384.0;
constexpr double kMostSlope = 16.0;

/// Linear value of the nearest sRGB code.
double coded(double linear) {
  return static_cast<double>(
      linear_from_srgb(static_cast<float>(srgb8_from_linear(static_cast<float>(linear))) / 255.0f));
}

double bilinear(const ImageF& map, double u, double v, int channel) {
  const double x = std::clamp(u * map.width() - 0.5, 0.0, map.width() - 1.0);
  const double y = std::clamp(v * map.height() - 0.5, 0.0, map.height() - 1.0);
  const auto hat = [](double d) { return std::max(0.0, 1.0 - std::abs(d)); };
  double sum = 0.0;
  for (int py = static_cast<int>(y); py <= std::min(static_cast<int>(y) + 1, map.height() - 1); ++py) {
    for (int px = static_cast<int>(x); px <= std::min(static_cast<int>(x) + 1, map.width() - 1); ++px) {
      sum += hat(x - px) * hat(y - py) * static_cast<double>(map.at(px, py, std::min(channel, map.channels() - 1)));
    }
  }
  return sum;
}

/// @param places  Of the scene.
double picture_value(const ColorSource& source, const composition::TexelPlaces& places, TexelIndex t, int channel) {
  if (source.image.empty()) return coded(source.color[channel]);
  if (source.image_mm > 0.0) {
    const composition::LaidPicture laid(source, places.surface().median_texel_size_mm());
    return coded(laid.color(places.point(t), places.normal(t))[channel]);
  }
  const int x = places.surface().grid().x(t), y = places.surface().grid().y(t);
  return coded(static_cast<double>(source.image.at(x % source.image.width(), y % source.image.height(),
                                                   std::min(channel, source.image.channels() - 1))));
}

/// @param amount  With its variation. @param mix  Of the second color, [0, 1].
double color_by_amount(const std::vector<ColorStop>& stops, double amount, double mix, int channel) {
  const auto color_at = [&](const ColorStop& stop) {
    const double first = coded(stop.color[channel]);
    return first + mix * (coded(stop.second_color.value_or(stop.color)[channel]) - first);
  };
  if (amount <= stops.front().amount) return color_at(stops.front());
  for (std::size_t i = 1; i < stops.size(); ++i) {
    if (amount > stops[i].amount) continue;
    const double share = (amount - stops[i - 1].amount) / (stops[i].amount - stops[i - 1].amount);
    return color_at(stops[i - 1]) + share * (color_at(stops[i]) - color_at(stops[i - 1]));
  }
  return color_at(stops.back());
}

ReferenceTexel new_texel(const SceneObject& object, const std::array<double, 3>& square,
                         const composition::TexelPlaces& places, TexelIndex t) {
  const TileGrid& grid = places.surface().grid();
  const int x = grid.x(t), y = grid.y(t);
  const double u = ((x + 0.5) / grid.width - square[0]) / square[2];
  const double v = ((y + 0.5) / grid.height - (1.0 - square[1] - square[2])) / square[2];
  ReferenceTexel texel;
  for (int c = 0; c < 3; ++c) {
    texel.color[c] = object.color_map.empty() ? picture_value(object.preset.color, places, t, c)
                                              : coded(bilinear(object.color_map, u, v, c));
  }
  const double specular = object.specular_map.empty() ? object.preset.specular : bilinear(object.specular_map, u, v, 0);
  texel.specular = std::round(255.0 * std::clamp(specular, 0.0, 1.0)) / 255.0;
  if (!object.height_map.empty()) texel.height_mm = bilinear(object.height_map, u, v, 0);
  return texel;
}

void age(ReferenceTexel& texel, const Scene& scene, const composition::TexelPlaces& places,
         const composition::Grain& grain, const MaterialAtlas& atlas, TexelIndex t, ColorForm form) {
  double total = 0.0, cover = 0.0;
  Vec3 sum = Vec3::Zero();
  for (int m = 0; m < atlas.num_materials(); ++m) {
    const MaterialAppearance& look = scene.appearance[m];
    const double delta =
        (static_cast<double>(atlas.amount(m, t)) - static_cast<double>(atlas.original(m, t))) / kAmountOne;
    const auto material = static_cast<std::size_t>(m);
    const bool has_grain = grain.has(material);
    // Stored value, in 8 bits.
    const double xi =
        has_grain
            ? composition::grain_noise(static_cast<std::uint8_t>(255.0 * grain.value(material, t) + 0.5)) / 32768.0
            : composition::noise(t, composition::noise_key(m)) / 32768.0;
    const bool is_blended = has_grain && look.second_color && look.color.image.empty();
    const double w = std::min(
        kMostWeight, std::min(kMostWeight, std::max(0.0, delta) * look.strength) * (1.0 + look.variation * xi));
    total += w;
    if (delta > 0.0) cover += std::min(kMostWeight, std::min(kMostWeight, look.strength) * (1.0 + look.variation * xi));
    for (int c = 0; c < 3; ++c) {
      double color = picture_value(look.color, places, t, c);
      if (!look.colors.empty() && look.color.image.empty()) {
        color = color_by_amount(look.colors, std::max(0.0, delta) * (1.0 + look.variation * xi),
                                has_grain ? (xi + 1.0) / 2.0 : 0.0, c);
      } else if (is_blended)
        color += (coded((*look.second_color)[c]) - color) * (xi + 1.0) / 2.0;
      sum[c] += w * color;
    }
    texel.specular += delta * look.specular * (1.0 + look.specular_variation * xi);
    texel.height_mm += delta * look.height_mm * (1.0 + look.height_variation * xi);
  }
  Vec3 mixed = total >= 1.0 ? Vec3(sum / total) : Vec3(form == ColorForm::Published ? total * sum : sum);
  if (form == ColorForm::Printed) {
    total = std::min(1.0, cover);
    mixed = total * sum;
  }
  texel.color = (texel.color * std::max(0.0, 1.0 - total) + mixed).cwiseMin(1.0);
  texel.specular = std::clamp(texel.specular, 0.0, 1.0);
}

}  // namespace

std::vector<ReferenceTexel> compose_reference(const Scene& scene, const SceneMesh& scene_mesh,
                                              const MaterialAtlas& atlas, ColorForm form) {
  const SurfaceAtlas& surface = atlas.surface();
  const TileGrid& grid = surface.grid();
  std::vector<ReferenceTexel> texels(grid.num_texels());
  const composition::TexelPlaces places(scene_mesh, surface);
  composition::Grain grain(places);
  std::vector<double> lengths;
  for (const MaterialAppearance& look : scene.appearance) lengths.push_back(look.grain_mm);
  grain.set_lengths(lengths);
  std::map<std::string, SurfaceParameter> patterns;
  for (TexelIndex t = 0; t < grid.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const auto object = static_cast<std::size_t>(surface.object(surface.triangle(t)));
    const SceneObject& of = scene.objects[object];
    texels[t] = new_texel(of, scene_mesh.uv_squares[object], places, t);
    if (of.color_map.empty() && of.preset.color.image.empty() && of.preset.second_color) {
      if (!patterns.contains(of.preset.pattern)) {
        const std::vector<std::string> name{of.preset.pattern};
        patterns[name[0]] = make_parameters(name, scene, scene_mesh, surface, {}).front();
      }
      const double share = parameter_at(patterns[of.preset.pattern], t);
      const Vec3 color = of.preset.color.color + share * (*of.preset.second_color - of.preset.color.color);
      for (int c = 0; c < 3; ++c) texels[t].color[c] = coded(color[c]);
    }
    age(texels[t], scene, places, grain, atlas, t, form);
  }
  for (TexelIndex t = 0; t < grid.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    const composition::TexelFrame frame =
        composition::texel_frame(surface.mm_per_texel(surface.triangle(t)).cast<double>());
    if (frame.is_degenerate) continue;
    const std::array<TexelIndex, 4> around = surface.neighbors(t);
    Eigen::Vector4d difference = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < 4; ++k) {
      if (around[k] != kNoTexel) difference[static_cast<int>(k)] = texels[around[k]].height_mm - texels[t].height_mm;
    }
    // A neighbor beside, in another triangle, counts as one step; only those over seams have a place of their own.
    const bool is_border = std::binary_search(surface.border().begin(), surface.border().end(), t);
    const std::array<Vec2, 4> plain{Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)};
    const std::array<Vec2, 4> steps = is_border ? composition::neighbor_steps(scene_mesh, surface, t) : plain;
    const Vec2 per_step = composition::gradient_weights(steps) * difference;
    const Vec2 slope = (frame.step.inverse().transpose() * per_step).cwiseMax(-kMostSlope).cwiseMin(kMostSlope);
    texels[t].normal = Vec3(-slope.x(), -slope.y(), 1.0).normalized();
  }
  return texels;
}

}  // namespace patinate::simulation
