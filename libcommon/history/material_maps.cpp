#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "patinate/core/error.h"
#include "patinate/history/history_sampling.h"

namespace patinate {

namespace {

using Vector = Eigen::Vector3f;

Vector vector_at(const ImageF& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

/// Which extra of a frame holds it.
std::string extra_of(MaterialMap map) {
  return map == MaterialMap::Roughness ? "specular" : std::string(kMaterialMapNames[static_cast<std::size_t>(map)]);
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// What the image's x direction is on the surface, not yet of unit length; 0 beside it.
Vector along_x(const ImageF& position, const ImageF& surface, int x, int y) {
  const auto is_surface = [&](int i) { return i >= 0 && i < surface.width() && !vector_at(surface, i, y).isZero(); };
  const int left = is_surface(x - 1) ? x - 1 : x, right = is_surface(x + 1) ? x + 1 : x;
  return vector_at(position, right, y) - vector_at(position, left, y);
}

/// A frame's map as it is kept; normals in tangent space.
ImageF read_map(const History& history, MaterialMap map, int frame) {
  const ImageF extra = *history.read_frame_extra(frame, extra_of(map));
  if (map == MaterialMap::Normal) {
    const bool is_scanned = has(history.facts().maps, "position") && has(history.facts().maps, "normal");
    return tangent_space_normals(extra, is_scanned ? history.read_map("position") : ImageF(),
                                 is_scanned ? history.read_map("normal") : ImageF());
  }
  if (map == MaterialMap::Height || map == MaterialMap::Stddev) return extra;
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
      if (map == MaterialMap::Stddev) {
        for (int c = 0; c < 3; ++c) {
          const float a = values.at(x, y, c), b = next.at(x, y, c);
          // What only one frame knows is that one's.
          values.at(x, y, c) = a > 0.0f && b > 0.0f ? std::hypot((1.0f - fraction) * a, fraction * b) : std::max(a, b);
        }
        continue;
      }
      float& a = values.at(x, y);
      const float b = next.at(x, y);
      const bool is_gloss = map != MaterialMap::Height;
      if (is_gloss && a < 0.0f) {
        a = b;
      } else if (!is_gloss || b >= 0.0f) {
        a = (1.0f - fraction) * a + fraction * b;
      }
    }
  }
}

}  // namespace

std::vector<MaterialMap> material_maps(const HistoryFacts& history) {
  std::vector<MaterialMap> found;
  for (MaterialMap map :
       {MaterialMap::Normal, MaterialMap::Roughness, MaterialMap::Specular, MaterialMap::Height, MaterialMap::Stddev}) {
    const bool in_frame = std::any_of(history.frames.begin(), history.frames.end(),
                                      [&](const FrameFacts& f) { return has(f.extras, extra_of(map)); });
    if (in_frame || (map == MaterialMap::Height && has(history.maps, "height"))) found.push_back(map);
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
  std::vector<double> times;  // Of the frames that have it.
  std::vector<int> indices;
  for (std::size_t i = 0; i < facts.frames.size(); ++i) {
    if (!has(facts.frames[i].extras, extra_of(map))) continue;
    times.push_back(facts.frames[i].time);
    indices.push_back(static_cast<int>(i));
  }
  if (indices.empty()) return history.read_map("height");
  const TimePosition position = FrameLocator(std::move(times), between)(time);
  ImageF values = read_map(history, map, indices[static_cast<std::size_t>(position.index)]);
  if (position.fraction != 0.0) {
    blend(values, read_map(history, map, indices[static_cast<std::size_t>(position.index) + 1]), map,
          static_cast<float>(position.fraction));
  }
  const float unknown = map == MaterialMap::Roughness ? kUnknownRoughness : kUnknownSpecular;
  if (map == MaterialMap::Roughness || map == MaterialMap::Specular) {
    std::replace_if(
        values.values().begin(), values.values().end(), [](float v) { return v < 0.0f; }, unknown);
  }
  return values;
}

}  // namespace patinate
