#include "analysis/figures/color_stack.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

RunControl on_this_thread() {
  RunControl control;
  control.num_threads = 1;
  return control;
}

namespace {

/// Share of every pixel of the stack that the mask covers.
ImageF coverage_of(const ImageU8& mask, StackSize size) {
  ImageF share(mask.width(), mask.height());
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) share.data()[i] = mask.data()[i] != 0 ? 1.0f : 0.0f;
  if (size.width == mask.width() && size.height == mask.height()) return share;
  return downscale_area(share, size.width, size.height, on_this_thread());
}

/// Means over what the mask covers; 0 where that is nothing.
ImageF reduced(ImageF image, const ImageU8& mask, const ImageF& coverage) {
  if (coverage.same_size(image)) return image;
  const std::int64_t channels = image.channels();
  for (std::int64_t i = 0; i < image.num_pixels(); ++i) {
    if (mask.data()[i] == 0) std::fill_n(image.data() + i * channels, channels, 0.0f);
  }
  ImageF out = downscale_area(image, coverage.width(), coverage.height(), on_this_thread());
  for (std::int64_t i = 0; i < out.num_pixels(); ++i) {
    const float share = coverage.data()[i];
    for (std::int64_t c = 0; c < channels; ++c)
      out.data()[i * channels + c] = share > 0.0f ? out.data()[i * channels + c] / share : 0.0f;
  }
  return out;
}

}  // namespace

ImageU8 ColorStack::mask() const {
  ImageU8 out(width, height);
  for (std::uint32_t t : texels) out.data()[t] = 255;
  return out;
}

ImageF ColorStack::lab_image(std::size_t time, int channel) const {
  ImageF out(width, height);
  const std::span<const float> values = lab_at(time);
  for (std::size_t i = 0; i < texels.size(); ++i)
    out.data()[texels[i]] = values[3 * i + static_cast<std::size_t>(channel)];
  return out;
}

ImageF ColorStack::value_image(std::span<const float> values) const {
  ImageF out(width, height);
  for (std::size_t i = 0; i < values.size(); ++i) out.data()[texels[i]] = values[i];
  return out;
}

ImageF ColorStack::rgb_image(std::size_t time, float outside) const {
  ImageF out(width, height, 3, outside);
  const std::span<const float> values = rgb_at(time);
  for (std::size_t i = 0; i < texels.size(); ++i)
    std::copy_n(values.data() + 3 * i, 3, out.data() + 3 * std::size_t{texels[i]});
  return out;
}

StackSize stack_size(int width, int height, int size) {
  const int longer = std::max(width, height);
  if (size <= 0 || longer <= size) return {width, height};
  const auto scaled = [&](int side) {
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(side) * size / longer)));
  };
  return {scaled(width), scaled(height)};
}

ImageU8 common_mask(const TextureSeries& series, const std::vector<double>& times) {
  ImageU8 mask = series.mask(times.front());
  const std::vector<FrameFacts>& frames = series.facts().frames;
  if (std::none_of(frames.begin(), frames.end(), [](const FrameFacts& f) { return f.has_mask; })) return mask;
  for (double time : times) {
    const ImageU8 now = series.mask(time);
    for (std::int64_t i = 0; i < mask.num_pixels(); ++i) mask.data()[i] &= now.data()[i];
  }
  return mask;
}

StackSize stack_size(const TextureSeries& series, int size) {
  return stack_size(series.width(), series.height(), size);
}

ColorStack make_stack(const SurfaceSource& source, const std::vector<double>& times, StackSize scaled,
                      const RunControl& control) {
  if (times.empty()) throw InvalidInput("color stack: there is no time");
  const ImageU8& mask = source.mask;
  const ImageF coverage = coverage_of(mask, scaled);
  ColorStack stack;
  stack.width = scaled.width;
  stack.height = scaled.height;
  stack.times = stack.own_times = times;
  if (source.pixel_mm) stack.pixel_mm = *source.pixel_mm * mask.width() / scaled.width;
  for (std::int64_t i = 0; i < coverage.num_pixels(); ++i) {
    if (coverage.data()[i] >= 0.5f) stack.texels.push_back(static_cast<std::uint32_t>(i));
  }
  if (stack.texels.empty())
    throw InvalidInput(source.name + ": no texel shows the surface at all of the compared times");
  const std::size_t n = stack.num_texels();
  stack.rgb.resize(3 * n * times.size());
  stack.lab.resize(stack.rgb.size());
  if (source.deviation) stack.deviation.resize(stack.rgb.size());
  parallel_for(static_cast<std::int64_t>(times.size()), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      const ImageF frame = reduced(source.sample(times[t]), mask, coverage);
      for (std::size_t i = 0; i < n; ++i) {
        const float* from = frame.data() + 3 * std::size_t{stack.texels[i]};
        float* rgb = stack.rgb.data() + 3 * (t * n + i);
        float* out = stack.lab.data() + 3 * (t * n + i);
        std::copy_n(from, 3, rgb);
        const auto lab =
            lab_from_linear(static_cast<double>(from[0]), static_cast<double>(from[1]), static_cast<double>(from[2]));
        for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<float>(lab[c]);
      }
      if (!source.deviation) continue;
      const ImageF deviation = reduced(source.deviation(times[t]), mask, coverage);
      for (std::size_t i = 0; i < n; ++i)
        std::copy_n(deviation.data() + 3 * std::size_t{stack.texels[i]}, 3, stack.deviation.data() + 3 * (t * n + i));
    }
  });
  return stack;
}

ColorStack load_stack(const TextureSeries& series, const std::vector<double>& times, int size,
                      const RunControl& control) {
  if (times.empty()) throw InvalidInput("color stack: there is no time");
  SurfaceSource source{.name = series.name(),
                       .mask = common_mask(series, times),
                       .pixel_mm = series.pixel_mm(),
                       .sample = [&series](double time) { return series.sample(time); }};
  if (series.has_deviation()) source.deviation = [&series](double time) { return series.deviation(time); };
  ColorStack stack = make_stack(source, times, stack_size(series, size), control);
  const auto inside = [](const ImageU8& m) {
    return static_cast<double>(
        std::count_if(m.values().begin(), m.values().end(), [](std::uint8_t v) { return v != 0; }));
  };
  stack.seen_share = inside(source.mask) / std::max(1.0, inside(series.mask(times.front())));
  return stack;
}

std::vector<float> values_at(const ImageF& values, const ImageU8& mask, const ColorStack& stack) {
  const ImageF scaled = reduced(values, mask, coverage_of(mask, {stack.width, stack.height}));
  std::vector<float> out;
  out.reserve(stack.num_texels());
  for (std::uint32_t t : stack.texels) out.push_back(scaled.data()[t]);
  return out;
}

std::vector<float> control_at(const TextureSeries& series, const std::string& name, const ColorStack& stack) {
  return values_at(series.control(name), common_mask(series, stack.own_times.empty() ? stack.times : stack.own_times),
                   stack);
}

ColorStack restricted(const ColorStack& stack, const std::vector<std::uint32_t>& kept) {
  ColorStack out = stack;
  out.texels = kept;
  out.rgb.clear();
  out.lab.clear();
  out.deviation.clear();
  for (std::size_t t = 0; t < stack.num_times(); ++t) {
    std::size_t i = 0;
    for (std::uint32_t texel : kept) {
      while (stack.texels[i] < texel) ++i;
      const std::size_t at = 3 * (t * stack.num_texels() + i);
      const auto copy = [&](const std::vector<float>& from, std::vector<float>& to) {
        to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(at),
                  from.begin() + static_cast<std::ptrdiff_t>(at) + 3);
      };
      copy(stack.rgb, out.rgb);
      copy(stack.lab, out.lab);
      if (!stack.deviation.empty()) copy(stack.deviation, out.deviation);
    }
  }
  return out;
}

}  // namespace patinate::analysis
