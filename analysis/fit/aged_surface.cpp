#include "analysis/fit/aged_surface.h"

#include <Eigen/Core>
#include <algorithm>

#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

/// Colors as the files of a history hold them, so that equal surfaces are equal, captured or not.
ImageF as_halves(ImageF colors) {
  for (float& v : colors.values()) v = static_cast<float>(Eigen::half(v));
  return colors;
}

/// Two frames blended; the ends held.
ImageF sample_surface(const AgedSurface& frames, double time) {
  const auto after = std::lower_bound(frames.times.begin(), frames.times.end(), time);
  if (after == frames.times.end()) return as_halves(frames.colors.back());
  const auto k = static_cast<std::size_t>(after - frames.times.begin());
  if (k == 0 || *after == time) return as_halves(frames.colors[k]);
  const auto f = static_cast<float>((time - frames.times[k - 1]) / (frames.times[k] - frames.times[k - 1]));
  ImageF out = as_halves(frames.colors[k - 1]);
  const ImageF next_colors = as_halves(frames.colors[k]);
  const float* next = next_colors.data();
  for (float& v : out.values()) v += f * (*next++ - v);
  return out;
}

}  // namespace

ColorStack stack_of(const AgedSurface& frames, const std::vector<double>& times, int size, const RunControl& control) {
  if (frames.colors.empty() || frames.colors.size() != frames.times.size())
    throw InvalidInput("surface: there is not one frame a time");
  const SurfaceSource source{
      .name = frames.name, .mask = frames.mask, .pixel_mm = frames.texel_size_mm, .sample = [&frames](double time) {
        return sample_surface(frames, time);
      }};
  return make_stack(source, times, stack_size(frames.mask.width(), frames.mask.height(), size), control);
}

void write_surface(const std::filesystem::path& folder, const AgedSurface& frames, const std::string& key) {
  std::filesystem::create_directories(folder);
  HistoryManifest manifest;
  manifest.name = frames.name;
  manifest.origin = "simulated";
  manifest.width = frames.mask.width();
  manifest.height = frames.mask.height();
  manifest.texel_size_mm = frames.texel_size_mm;
  manifest.time_unit = frames.time_unit;
  manifest.key = key;
  HistoryWriter writer(folder, manifest);
  for (std::size_t i = 0; i < frames.times.size(); ++i)
    writer.write_frame(static_cast<int>(i), frames.times[i], frames.colors[i]);
  for (const SurfaceControl& c : frames.controls) {
    ImageF physical = c.values;
    for (float& v : physical.values())
      v = static_cast<float>(c.parameter.low + static_cast<double>(v) * (c.parameter.high - c.parameter.low));
    writer.write_control(c.parameter.name, physical, c.parameter.low, c.parameter.high, c.parameter.unit);
  }
  writer.write_mask(frames.mask);
  writer.finish();
}

}  // namespace patinate::analysis
