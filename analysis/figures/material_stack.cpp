#include "analysis/figures/material_stack.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/output/surface_material.h"
#include "patinate/history/history_sampling.h"

namespace patinate::analysis {

namespace {

constexpr std::array<double, 3> kViews{15.0, 45.0, 60.0};  ///< Degrees from the normal.
/// Degrees from the normal (docs/algorithms/compare.md).
constexpr std::array<double, 5> kLights{15.0, 30.0, 45.0, 60.0, 75.0};
/// Degrees around the normal, from the plane of view.
constexpr std::array<double, 3> kAround{0.0, 90.0, 180.0};
constexpr double kMinRoughness = 0.05;  ///< Least roughness as Lobe asks for.

Vec3 direction(double from_normal, double around) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  return {std::sin(from_normal * kDegree) * std::cos(around * kDegree),
          std::sin(from_normal * kDegree) * std::sin(around * kDegree), std::cos(from_normal * kDegree)};
}

std::array<Vec3, 16> light_directions() {
  std::array<Vec3, 16> out{Vec3::UnitZ()};
  std::size_t n = 1;
  for (const double light : kLights) {
    for (const double around : kAround) out[n++] = direction(light, around);
  }
  return out;
}

bool has_map(const TextureSeries& series, MaterialMap map) {
  const std::vector<MaterialMap> there = material_maps(series.facts());
  return std::find(there.begin(), there.end(), map) != there.end();
}

/// One of the history's maps, or of its colors, at one time and the stack's texels.
class Sampler {
 public:
  Sampler(const TextureSeries& series, const ColorStack& stack, double time)
      : series_(&series), stack_(&stack), mask_(series.mask(time)) {
    const std::vector<FrameFacts>& frames = series.facts().frames;
    time_ = std::clamp(time, frames.front().time, frames.back().time);
  }

  [[nodiscard]] double time() const { return time_; }
  /// @returns `unknown` everywhere where no frame has it.
  [[nodiscard]] std::vector<float> map(MaterialMap map, float unknown) const {
    if (!has_map(*series_, map)) return std::vector<float>(stack_->num_texels(), unknown);
    return channels(sample_material_map(series_->history(), map, time_, Between::Blend));
  }
  /// Texel by texel.
  [[nodiscard]] std::vector<float> channels(const ImageF& image) const {
    const ImageF there = series_->on_surface(image);
    const auto count = static_cast<std::size_t>(there.channels());
    std::vector<float> out(count * stack_->num_texels());
    for (int c = 0; c < there.channels(); ++c) {
      ImageF plane(there.width(), there.height());
      for (std::int64_t i = 0; i < plane.num_pixels(); ++i) plane.data()[i] = there.data()[there.channels() * i + c];
      const std::vector<float> values = values_at(plane, mask_, *stack_);
      for (std::size_t i = 0; i < values.size(); ++i) out[count * i + static_cast<std::size_t>(c)] = values[i];
    }
    return out;
  }

 private:
  const TextureSeries* series_;
  const ColorStack* stack_;
  ImageU8 mask_;
  double time_ = 0.0;
};

void append(std::vector<float>& all, const std::vector<float>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

float MaterialStack::reflectance(std::size_t at) const {
  const auto mean = [&](const std::vector<float>& v) { return (v[3 * at] + v[3 * at + 1] + v[3 * at + 2]) / 3.0f; };
  return (1.0f - metalness[at]) * mean(specular) + metalness[at] * mean(base);
}

bool states_material(const HistoryFacts& facts) {
  const std::vector<MaterialMap> there = material_maps(facts);
  return std::any_of(there.begin(), there.end(),
                     [](MaterialMap map) { return map != MaterialMap::Stddev && map != MaterialMap::Normal; });
}

MaterialStack load_materials(const TextureSeries& series, const ColorStack& stack, std::span<const std::size_t> times,
                             const RunControl& control) {
  MaterialStack out;
  out.num_texels = stack.num_texels();
  for (const std::size_t t : times) {
    control.throw_if_stopped();
    const Sampler at(series, stack, stack.own_times[t]);
    append(out.roughness, at.map(MaterialMap::Roughness, kUnknownRoughness));
    append(out.metalness, at.map(MaterialMap::Metalness, 0.0f));
    if (has_map(series, MaterialMap::Height)) append(out.height, at.map(MaterialMap::Height, 0.0f));
    append(out.base, at.channels(sample_base_color(series.history(), at.time(), Between::Blend)));
    const ImageF specular = sample_reflectance(series.history(), at.time(), Between::Blend);
    append(out.specular,
           specular.empty() ? std::vector<float>(3 * out.num_texels, kUnknownSpecular) : at.channels(specular));
  }
  return out;
}

Reflections reflections_of(const MaterialStack& stack, std::size_t at) {
  static const std::array<Vec3, 16> kDirections = light_directions();
  const auto color = [&](const std::vector<float>& v) {
    return Vec3(static_cast<double>(v[3 * at]), static_cast<double>(v[3 * at + 1]), static_cast<double>(v[3 * at + 2]));
  };
  SeenPoint point;
  point.color = color(stack.base).cwiseMax(0.0).cwiseMin(1.0);
  point.specular = color(stack.specular).cwiseMax(0.0).cwiseMin(1.0);
  point.roughness = std::clamp(static_cast<double>(stack.roughness[at]), kMinRoughness, 1.0);
  point.metalness = std::clamp(static_cast<double>(stack.metalness[at]), 0.0, 1.0);
  Reflections out{};
  std::size_t n = 0;
  for (const double view : kViews) {
    point.view = direction(view, 0.0);
    const SurfaceMaterial material(point);
    for (const Vec3& light : kDirections) {
      const Vec3 seen = material.reflection(light).value + material.diffuse() * (light.z() / std::numbers::pi);
      for (int c = 0; c < 3; ++c) out[n++] = static_cast<float>(std::log1p(std::max(0.0, seen[c])));
    }
  }
  return out;
}

double reflection_distance(std::span<const double, kNumReflections> a, std::span<const double, kNumReflections> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kNumReflections; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(kNumReflections));
}

}  // namespace patinate::analysis
