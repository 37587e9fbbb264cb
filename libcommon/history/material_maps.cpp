#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "libcommon/history/frame_locator.h"
#include "patinate/core/error.h"
#include "patinate/history/history_sampling.h"

namespace patinate {

namespace {

using Vector = Eigen::Vector3f;

Vector vector_at(const ImageF& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

/// Extra of a frame that holds it.
std::string extra_of(MaterialMap map) {
  return map == MaterialMap::Roughness ? "specular" : std::string(kMaterialMapNames[static_cast<std::size_t>(map)]);
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Direction of the image's x on the surface, not yet of unit length; 0 beside it.
Vector along_x(const ImageF& position, const ImageF& surface, int x, int y) {
  const auto is_surface = [&](int i) { return i >= 0 && i < surface.width() && !vector_at(surface, i, y).isZero(); };
  const int left = is_surface(x - 1) ? x - 1 : x, right = is_surface(x + 1) ? x + 1 : x;
  return vector_at(position, right, y) - vector_at(position, left, y);
}

/// A map of its own, of all times.
constexpr int kConstant = -1;

/// A frame's map as it is kept, or the one that is constant; normals in tangent space.
ImageF read_map(const History& history, MaterialMap map, int frame) {
  const ImageF extra =
      frame == kConstant ? history.read_map(extra_of(map)) : *history.read_frame_extra(frame, extra_of(map));
  if (map == MaterialMap::Normal) {
    const bool is_scanned = has(history.facts().maps, "position") && has(history.facts().maps, "normal");
    return tangent_space_normals(extra, is_scanned ? history.read_map("position") : ImageF(),
                                 is_scanned ? history.read_map("normal") : ImageF());
  }
  if (map != MaterialMap::Roughness && map != MaterialMap::Specular) return extra;
  ImageF values(extra.width(), extra.height());
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      const float strength = extra.at(x, y, 0), roughness = extra.at(x, y, 1);
      const bool is_known = strength > 0.0f || roughness > 0.0f;
      // -1 until it is clear that the other frame does not know it either.
      values.at(x, y) = !is_known                       ? -1.0f
                        : map == MaterialMap::Roughness ? std::clamp(roughness, 0.0f, 1.0f)
                                                        : std::max(0.0f, strength);
    }
  }
  return values;
}

void blend(ImageF& values, const ImageF& next, MaterialMap map, float fraction) {
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      if (map == MaterialMap::Normal) {
        const Vector n = (1.0f - fraction) * vector_at(values, x, y) + fraction * vector_at(next, x, y);
        const Vector unit = n.norm() > 1e-6f ? Vector(n.normalized()) : Vector(0.0f, 0.0f, 1.0f);
        std::copy_n(unit.data(), 3, values.pixel(x, y).begin());
        continue;
      }
      if (map == MaterialMap::Tint) {
        const Vector a = vector_at(values, x, y), b = vector_at(next, x, y);
        const Vector mixed = a.isZero() ? b : b.isZero() ? a : Vector((1.0f - fraction) * a + fraction * b);
        std::copy_n(mixed.data(), 3, values.pixel(x, y).begin());
        continue;
      }
      if (map == MaterialMap::Stddev) {
        for (int c = 0; c < 3; ++c) {
          const float a = values.at(x, y, c), b = next.at(x, y, c);
          // Values that only one frame knows are that one's.
          values.at(x, y, c) = a > 0.0f && b > 0.0f ? std::hypot((1.0f - fraction) * a, fraction * b) : std::max(a, b);
        }
        continue;
      }
      float& a = values.at(x, y);
      const float b = next.at(x, y);
      const bool is_gloss = map == MaterialMap::Roughness || map == MaterialMap::Specular;
      if (is_gloss && a < 0.0f) {
        a = b;
      } else if (!is_gloss || b >= 0.0f) {
        a = (1.0f - fraction) * a + fraction * b;
      }
    }
  }
}

bool has_map(const History& history, MaterialMap map) {
  const std::vector<MaterialMap> there = material_maps(history.facts());
  return std::find(there.begin(), there.end(), map) != there.end();
}

/// Where nobody says it: metal reflects in its color, the rest in white.
void fill_unknown_tint(const History& history, double time, Between between, ImageF& tint) {
  const auto is_unknown = [&](std::int64_t i) {
    return tint.data()[3 * i] == 0.0f && tint.data()[3 * i + 1] == 0.0f && tint.data()[3 * i + 2] == 0.0f;
  };
  std::int64_t first = 0;
  while (first < tint.num_pixels() && !is_unknown(first)) ++first;
  if (first == tint.num_pixels()) return;
  const bool has_metal = has_map(history, MaterialMap::Metalness);
  const ImageF color = sample(history, time, between);
  const ImageF metalness = has_metal ? sample_material_map(history, MaterialMap::Metalness, time, between)
                                     : ImageF(color.width(), color.height());
  for (std::int64_t i = first; i < tint.num_pixels(); ++i) {
    if (!is_unknown(i)) continue;
    const float m = metalness.data()[i];
    for (std::int64_t c = 3 * i; c < 3 * i + 3; ++c)
      tint.data()[c] = 1.0f + m * (std::clamp(color.data()[c], 0.0f, 1.0f) - 1.0f);
  }
}

}  // namespace

std::vector<MaterialMap> material_maps(const HistoryFacts& history) {
  std::vector<MaterialMap> found;
  for (std::size_t i = 0; i < kMaterialMapNames.size(); ++i) {
    const auto map = static_cast<MaterialMap>(i);
    const bool in_frame = std::any_of(history.frames.begin(), history.frames.end(),
                                      [&](const FrameFacts& f) { return has(f.extras, extra_of(map)); });
    const bool may_be_constant = map != MaterialMap::Normal && map != MaterialMap::Stddev;
    if (in_frame || (may_be_constant && has(history.maps, extra_of(map)))) found.push_back(map);
  }
  return found;
}

ImageF tangent_space_normals(const ImageF& normals, const ImageF& position, const ImageF& surface) {
  const bool is_flat = position.empty() && surface.empty();
  if (normals.channels() != 3 || (!is_flat && (!position.same_size(normals) || !surface.same_size(normals) ||
                                               position.channels() != 3 || surface.channels() != 3))) {
    throw InvalidInput("normals: expected three numbers a pixel, and a surface of the same size or none");
  }
  ImageF out(normals.width(), normals.height(), 3);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const Vector n = vector_at(normals, x, y);
      Vector t(0.0f, 0.0f, 1.0f);
      if (!n.isZero() && is_flat) {
        t = n.normalized();
      } else if (!n.isZero()) {
        const Vector z = vector_at(surface, x, y).normalized();
        const Vector step = along_x(position, surface, x, y);
        const Vector flat = step - step.dot(z) * z;
        if (!z.isZero() && flat.norm() > 0.0f) {
          const Vector right = flat.normalized();
          t = Vector(n.dot(right), n.dot(z.cross(right)), n.dot(z)).normalized();
        }
      }
      std::copy_n(t.data(), 3, out.pixel(x, y).begin());
    }
  }
  return out;
}

ImageF sample_material_map(const History& history, MaterialMap map, double time, Between between) {
  const HistoryFacts& facts = history.facts();
  const std::vector<MaterialMap> there = material_maps(facts);
  if (std::find(there.begin(), there.end(), map) == there.end()) {
    std::string names;
    for (MaterialMap m : there)
      names += (names.empty() ? "" : ", ") + std::string(kMaterialMapNames[static_cast<std::size_t>(m)]);
    throw InvalidInput(history.label() + ": its frames have no `" +
                       std::string(kMaterialMapNames[static_cast<std::size_t>(map)]) + "`; beside color there " +
                       (names.empty() ? "is nothing" : "is: " + names));
  }
  if (std::isnan(time)) throw InvalidInput("time: is not a number");
  std::vector<double> times;  // Times of the frames that have it.
  std::vector<int> indices;
  for (std::size_t i = 0; i < facts.frames.size(); ++i) {
    if (!has(facts.frames[i].extras, extra_of(map))) continue;
    times.push_back(facts.frames[i].time);
    indices.push_back(static_cast<int>(i));
  }
  TimePosition position;
  if (indices.empty()) {
    indices = {kConstant};
  } else {
    position = FrameLocator(std::move(times), between)(time);
  }
  ImageF values = read_map(history, map, indices[position.index]);
  if (position.fraction != 0.0) {
    blend(values, read_map(history, map, indices[static_cast<std::size_t>(position.index) + 1]), map,
          static_cast<float>(position.fraction));
  }
  const float unknown = map == MaterialMap::Roughness ? kUnknownRoughness : kUnknownSpecular;
  if (map == MaterialMap::Roughness || map == MaterialMap::Specular) {
    std::replace_if(
        values.values().begin(), values.values().end(), [](float v) { return v < 0.0f; }, unknown);
  }
  if (map == MaterialMap::Tint) fill_unknown_tint(history, time, between, values);
  return values;
}

ImageF sample_base_color(const History& history, double time, Between between) {
  ImageF color = sample(history, time, between);
  const auto is_there = [&](MaterialMap map) { return has_map(history, map); };
  if (!is_there(MaterialMap::Tint) || !is_there(MaterialMap::Metalness)) return color;
  const ImageF tint = sample_material_map(history, MaterialMap::Tint, time, between);
  const ImageF metalness = sample_material_map(history, MaterialMap::Metalness, time, between);
  for (std::int64_t i = 0; i < metalness.num_pixels(); ++i) {
    const float m = metalness.data()[i];
    for (std::int64_t c = 3 * i; c < 3 * i + 3; ++c) color.data()[c] += m * (tint.data()[c] - color.data()[c]);
  }
  return color;
}

ImageF sample_reflectance(const History& history, double time, Between between) {
  const auto is_there = [&](MaterialMap map) { return has_map(history, map); };
  if (!is_there(MaterialMap::Specular)) return {};
  const ImageF strength = sample_material_map(history, MaterialMap::Specular, time, between);
  ImageF reflectance = is_there(MaterialMap::Tint) ? sample_material_map(history, MaterialMap::Tint, time, between)
                                                   : ImageF(strength.width(), strength.height(), 3, 1.0f);
  for (std::int64_t i = 0; i < strength.num_pixels(); ++i) {
    for (std::int64_t c = 3 * i; c < 3 * i + 3; ++c)
      reflectance.data()[c] = std::min(1.0f, strength.data()[i] * reflectance.data()[c]);
  }
  return reflectance;
}

ImageF sample_orm(const History& history, double time, Between between) {
  const auto is_there = [&](MaterialMap map) { return has_map(history, map); };
  if (!is_there(MaterialMap::Roughness) && !is_there(MaterialMap::Metalness))
    throw InvalidInput(history.label() +
                       ": knows neither roughness nor metalness; `patinate history material` states them");
  const auto sampled = [&](MaterialMap map, float unknown) {
    return is_there(map) ? sample_material_map(history, map, time, between)
                         : ImageF(history.facts().width, history.facts().height, 1, unknown);
  };
  const ImageF roughness = sampled(MaterialMap::Roughness, kUnknownRoughness);
  const ImageF metalness = sampled(MaterialMap::Metalness, 0.0f);
  ImageF orm(roughness.width(), roughness.height(), 3, 1.0f);
  for (std::int64_t i = 0; i < roughness.num_pixels(); ++i) {
    orm.data()[3 * i + 1] = roughness.data()[i];
    orm.data()[3 * i + 2] = metalness.data()[i];
  }
  return orm;
}

}  // namespace patinate
