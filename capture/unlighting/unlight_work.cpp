#include "capture/unlighting/unlight_work.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "capture/unlighting/cast_shadows.h"
#include "capture/unlighting/photometric_normals.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr std::int64_t kWorkRowsAChunk = 4;
constexpr std::size_t kMaxLights = 1000;

std::string numbered(const char* what, std::size_t i) { return std::string(what) + " " + std::to_string(i + 1); }

void check_lights(const UnlightInput& in) {
  bool is_any_near = false;
  for (std::size_t k = 0; k < in.lights.size(); ++k) {
    const Light& light = in.lights[k];
    if (!light.intensity.allFinite() || !(light.intensity.minCoeff() > 0.0)) {
      throw InvalidInput(numbered("light", k) + " has the intensity " + short_number_text(light.intensity.x()) + " " +
                         short_number_text(light.intensity.y()) + " " + short_number_text(light.intensity.z()) +
                         "; all three must be above 0");
    }
    is_any_near = is_any_near || light.kind == Light::Kind::Near;
    const bool is_near = light.kind == Light::Kind::Near;
    if (!(is_near ? light.position : light.direction).allFinite())
      throw InvalidInput(numbered("light", k) + " is not finite");
    if (!is_near && !(std::abs(light.direction.norm() - 1.0) < 1e-6))
      throw InvalidInput(numbered("light", k) + ": its direction must be a unit vector");
  }
  if (is_any_near && in.position_mm.empty()) throw InvalidInput("near lights need the surface's positions (a scan)");
  if (in.camera_center && in.position_mm.empty())
    throw InvalidInput("a camera's place means nothing without the surface's positions");
  if (!(std::abs(in.view_direction.norm() - 1.0) < 1e-6)) throw InvalidInput("view_direction must be a unit vector");
  if (in.blockers != nullptr && in.position_mm.empty()) throw InvalidInput("cast shadows need the surface's positions");
}

void check_sizes(const UnlightInput& in) {
  if (in.photos.empty()) throw InvalidInput("there is no photograph");
  if (in.photos.size() != in.lights.size()) {
    throw InvalidInput("there are " + std::to_string(in.photos.size()) + " photographs and " +
                       std::to_string(in.lights.size()) + " lights; one photograph for each light is expected");
  }
  if (in.lights.size() > kMaxLights)
    throw InvalidInput("there are more than " + std::to_string(kMaxLights) + " lights");
  const ImageF& first = in.photos.front();
  if (first.empty() || (first.channels() != 1 && first.channels() != 3))
    throw InvalidInput("photographs must have 1 or 3 channels");
  for (std::size_t k = 0; k < in.photos.size(); ++k) {
    if (!in.photos[k].same_size(first) || in.photos[k].channels() != first.channels()) {
      throw InvalidInput(numbered("photograph", k) + " is " + size_text(in.photos[k].width(), in.photos[k].height()) +
                         " x " + std::to_string(in.photos[k].channels()) + "; the first is " +
                         size_text(first.width(), first.height()) + " x " + std::to_string(first.channels()));
    }
  }
  if (!in.valid.empty() && in.valid.size() != in.photos.size())
    throw InvalidInput("`valid` must have one mask for each photograph, or none");
  for (const ImageU8& valid : in.valid) {
    if (!valid.same_size(first)) throw InvalidInput("a mask of valid samples differs in size from the photographs");
  }
  const auto check_map = [&](const ImageF& map, const char* name) {
    if (!map.empty() && (!map.same_size(first) || map.channels() != 3))
      throw InvalidInput(std::string(name) + " differ in size from the photographs");
  };
  check_map(in.position_mm, "positions");
  check_map(in.normal, "normals");
  if (!in.mask.empty() && !in.mask.same_size(first))
    throw InvalidInput("the mask differs in size from the photographs");
}

[[noreturn]] void fail_at(const std::string& what, int x, int y) {
  throw InvalidInput(what + " at pixel (" + std::to_string(x) + ", " + std::to_string(y) + ") is not finite");
}

/// The states of one texel's samples that need no fit.
void classify(const UnlightWork& work, const ImageU8& shadow, int x, int y, std::span<std::uint8_t> states) {
  const UnlightInput& in = work.input;
  const Vec3 n = vector_of(work.normal, x, y);
  const bool has_normal = n.squaredNorm() > 0.5;
  const Vec3 p = work.position(x, y);
  for (std::size_t k = 0; k < states.size(); ++k) {
    SampleState state = SampleState::Clean;
    const Light& light = in.lights[k];
    const bool is_at_light = light.kind == Light::Kind::Near && !((light.position - p).squaredNorm() > 1e-12);
    if (!in.valid.empty() && in.valid[k].at(x, y) == 0) state = SampleState::Invalid;
    if (!shadow.empty() && shadow.at(x, y, static_cast<int>(k)) != 0) state = SampleState::CastShadow;
    if (is_at_light || !has_normal || n.dot(direction_to(light, p)) < work.options.min_cosine)
      state = SampleState::Unlit;
    states[k] = static_cast<std::uint8_t>(state);
  }
}

template <typename Image>
Image thinned(const Image& in, int step) {
  if (in.empty()) return {};
  Image out(std::max(1, in.width() / step), std::max(1, in.height() / step), in.channels());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const int from_x = std::min(in.width() - 1, x * step + step / 2),
                from_y = std::min(in.height() - 1, y * step + step / 2);
      std::copy_n(in.pixel(from_x, from_y).begin(), in.channels(), out.pixel(x, y).begin());
    }
  }
  return out;
}

}  // namespace

UnlightWork::UnlightWork(const UnlightInput& in, const UnlightOptions& o, const RunControl& control)
    : input(in), options(o) {
  check_ranges(options);
  check_sizes(input);
  check_lights(input);
  width = input.photos.front().width();
  height = input.photos.front().height();
  num_lights = static_cast<int>(input.lights.size());
  num_channels = input.photos.front().channels();
  strengths.assign(input.lights.size(), Vec3::Ones());
  normal = ImageF(width, height, 3);
  parallel_for(height, kWorkRowsAChunk, control.part(0.0, 0.1), [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        if (!is_surface(x, y)) continue;
        const Vec3 n = input.normal.empty() ? Vec3::Zero() : vector_of(input.normal, x, y);
        if (!n.allFinite()) fail_at("the normal", x, y);
        if (!position(x, y).allFinite()) fail_at("the position", x, y);
        for (std::size_t k = 0; k < input.photos.size(); ++k) {
          for (float v : input.photos[k].pixel(x, y)) {
            if (!std::isfinite(v)) fail_at(numbered("photograph", k), x, y);
          }
        }
        if (!(n.norm() > 1e-6)) continue;
        const Eigen::Vector3f unit = n.normalized().cast<float>();
        for (int c = 0; c < 3; ++c) normal.at(x, y, c) = unit[c];
      }
    }
  });
  if (input.normal.empty()) {
    if (options.normals == NormalMode::Keep)
      throw InvalidInput("there are no normals to keep; without a scan they come from the photographs");
    normal = photometric_normals(input.photos, input.valid, input.mask, input.lights, control.part(0.1, 0.5));
  }
  ImageU8 shadow;
  if (input.blockers != nullptr && !input.blockers->triangles.empty()) {
    const double offset = options.shadow_offset_mm.value_or(median_edge(*input.blockers));
    shadow = cast_shadows(*input.blockers, input.position_mm, normal, input.mask, input.lights, offset,
                          control.part(0.5, 0.9));
  }
  samples = ImageU8(width, height, num_lights);
  parallel_for(height, kWorkRowsAChunk, control.part(0.9, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        if (is_surface(x, y)) classify(*this, shadow, x, y, samples.pixel(x, y));
      }
    }
  });
}

UnlightWork::UnlightWork(const UnlightInput& in, const UnlightOptions& o, const UnlightResult& result)
    : input(in),
      options(o),
      width(result.mask.width()),
      height(result.mask.height()),
      num_lights(result.samples.channels()),
      num_channels(result.albedo.channels()),
      normal(in.normal.empty() ? result.normal : in.normal),
      samples(result.samples),
      indirect(result.indirect),
      ambient(result.ambient),
      noise_scale(result.noise_scale),
      form(result.form),
      specular(result.specular),
      highlight_normal(result.normal),
      highlight_base(result.albedo),
      highlight_tint(result.tint),
      highlight_metal(result.metalness) {
  for (const LightReport& light : result.lights) strengths.push_back(light.strength);
  for (std::uint8_t& state : samples.values()) {
    if (state == static_cast<std::uint8_t>(SampleState::Darker) ||
        state == static_cast<std::uint8_t>(SampleState::Brighter)) {
      state = static_cast<std::uint8_t>(SampleState::Clean);
    }
  }
}

UnlightInput thinned_input(const UnlightInput& in, int step) {
  UnlightInput thin{.lights = in.lights, .camera_center = in.camera_center, .view_direction = in.view_direction};
  for (const ImageF& photo : in.photos) thin.photos.push_back(thinned(photo, step));
  for (const ImageU8& valid : in.valid) thin.valid.push_back(thinned(valid, step));
  thin.position_mm = thinned(in.position_mm, step);
  thin.normal = thinned(in.normal, step);
  thin.mask = thinned(in.mask, step);
  return thin;
}

UnlightWork::UnlightWork(const UnlightInput& thin, const UnlightWork& whole, int step)
    : input(thin),
      options(whole.options),
      width(thin.photos.front().width()),
      height(thin.photos.front().height()),
      num_lights(whole.num_lights),
      num_channels(whole.num_channels),
      normal(thinned(whole.normal, step)),
      samples(thinned(whole.samples, step)),
      indirect(thinned(whole.indirect, step)),
      strengths(whole.strengths),
      ambient(whole.ambient),
      noise_scale(whole.noise_scale),
      form(whole.form),
      highlight_step(std::max(1, kHighlightStep / step)) {}

Vec3 UnlightWork::position(int x, int y) const {
  return input.position_mm.empty() ? Vec3(0, 0, 0) : vector_of(input.position_mm, x, y);
}

TexelFitOptions UnlightWork::fit_options() const {
  return {.refine_normal = options.normals == NormalMode::Refine,
          .normal_sigma = input.normal.empty() ? std::numeric_limits<double>::infinity()
                                               : options.normal_sigma_deg * std::numbers::pi / 180.0,
          .reject = options.rejection == Rejection::Robust,
          .rejection_sigma = options.rejection_sigma,
          .noise_scale = noise_scale,
          .min_cosine = options.min_cosine,
          .min_lights = options.min_lights};
}

Vec3 UnlightWork::to_camera(int x, int y) const {
  return input.camera_center ? Vec3((*input.camera_center - position(x, y)).normalized()) : input.view_direction;
}

std::array<double, 3> UnlightWork::tint(SpecularTint kind, int x, int y) const {
  std::array<double, 3> tint{1.0, 1.0, 1.0};
  if (!highlight_tint.empty()) {
    for (std::size_t c = 0; c < 3; ++c) tint[c] = static_cast<double>(highlight_tint.at(x, y, static_cast<int>(c)));
    return tint;
  }
  if (kind == SpecularTint::White || num_channels == 1) return tint;
  double mean = 0.0;
  for (float v : highlight_base.pixel(x, y)) mean += static_cast<double>(v) / num_channels;
  if (!(mean > 0.0)) return tint;
  for (int c = 0; c < num_channels; ++c) tint[c] = static_cast<double>(highlight_base.at(x, y, c)) / mean;
  return tint;
}

void UnlightWork::load(int x, int y, TexelSamples& texel) const {
  load_raw(x, y, texel);
  if (specular.empty() || !(specular.at(x, y, 0) > 0.0f)) return;
  texel.highlight = {.strength = static_cast<double>(specular.at(x, y, 0)),
                     .roughness = static_cast<double>(specular.at(x, y, 1)),
                     .form = form,
                     .tint = tint(form.tint, x, y),
                     .to_camera = to_camera(x, y),
                     .freedom = highlight_freedom,
                     .metal = highlight_metal.empty() ? 0.0 : static_cast<double>(highlight_metal.at(x, y))};
  add_highlight_variance(texel, vector_of(highlight_normal, x, y));
}

void UnlightWork::add_highlight_variance(TexelSamples& texel, const Vec3& n) const {
  for (int k = 0; k < num_lights; ++k) {
    for (int c = 0; c < num_channels; ++c) {
      const double off = highlight_off * highlight_value(texel, k, c, n) / noise_scale;
      texel.variance[texel.index(k, c)] += off * off;
    }
  }
}

void UnlightWork::load_raw(int x, int y, TexelSamples& texel) const {
  texel.resize(num_lights, num_channels);
  texel.highlight.strength = 0.0;
  const Vec3 n = vector_of(normal, x, y);
  texel.normal = n.squaredNorm() > 0.0 ? Vec3(n.normalized()) : Vec3(0, 0, 1);
  const Vec3 p = position(x, y);
  const auto states = samples.pixel(x, y);
  for (int k = 0; k < num_lights; ++k) {
    const auto i = static_cast<std::size_t>(k);
    texel.state[i] = static_cast<SampleState>(states[i]);
    const Light& light = input.lights[i];
    texel.direction[i] = direction_to(light, p);
    const Vec3 irradiance = light_at(light, p).cwiseProduct(strengths[i]) / std::numbers::pi;
    for (int c = 0; c < num_channels; ++c) {
      const auto at = texel.index(k, c);
      texel.irradiance[at] = num_channels == 1 ? irradiance.mean() : irradiance[c];
      texel.ambient[at] = ambient[c] / std::numbers::pi;
      if (!indirect.empty()) texel.ambient[at] += static_cast<double>(indirect.at(x, y, static_cast<int>(at)));
      const auto value = static_cast<double>(input.photos[i].at(x, y, c));
      texel.value[at] = value;
      texel.variance[at] = variance_of(value);
    }
  }
}

std::vector<std::int64_t> UnlightWork::spread_texels(std::int64_t max_count) const {
  std::int64_t count = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) count += is_surface(x, y) ? 1 : 0;
  }
  const std::int64_t every = std::max<std::int64_t>(1, (count + max_count - 1) / std::max<std::int64_t>(1, max_count));
  std::vector<std::int64_t> texels;
  std::int64_t seen = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!is_surface(x, y)) continue;
      // One of every block, at a place that walks through it by the golden section: no stripes.
      const std::int64_t block = seen / every, within = seen % every;
      const auto chosen = static_cast<std::int64_t>((static_cast<std::uint64_t>(block) * 0x9E3779B97F4A7C15ULL >> 33U) %
                                                    static_cast<std::uint64_t>(every));
      if (within == chosen) texels.push_back(std::int64_t{y} * width + x);
      ++seen;
    }
  }
  return texels;
}

}  // namespace patinate::capture
