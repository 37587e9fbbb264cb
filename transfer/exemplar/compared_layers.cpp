#include "transfer/exemplar/compared_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "libcommon/image/filters.h"

namespace patinate::transfer {

namespace {

constexpr std::array<std::string_view, 3> kMaterialMaps{"specular", "metalness", "height"};
constexpr std::string_view kHeight = "height";
/// Gaussian that removes the object's shape (docs/algorithms/appearance_space.md).
constexpr double kReliefSigma_px = 8.0;

bool has(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// In pixels.
ImageF relief_of(ImageF height, const ImageU8& mask, double pixel_mm, const RunControl& control) {
  const ImageF around = gaussian_blur(height, mask, kReliefSigma_px, control);
  const auto scale = static_cast<float>(1.0 / pixel_mm);
  for (std::int64_t i = 0; i < height.num_pixels(); ++i)
    height.data()[i] = scale * (height.data()[i] - around.data()[i]);
  return height;
}

ImageF frame_map(const History& history, int frame, const std::string& name, const ImageU8& mask,
                 const RunControl& control) {
  ImageF image = history.read_frame_extra(frame, name).value();
  return name == kHeight ? relief_of(std::move(image), mask, history.facts().texel_size_mm.value_or(1.0), control)
                         : image;
}

}  // namespace

bool is_compared(const std::string& name, bool is_of_frame) {
  return std::find(kMaterialMaps.begin(), kMaterialMaps.end(), name) != kMaterialMaps.end() &&
         (is_of_frame || name != kHeight);
}

double ComparedLayer::value(const ImageF& image, std::int64_t pixel, int channel) const {
  const auto v = static_cast<double>(image.data()[pixel * num_channels + channel]);
  return material ? weight * v : std::sqrt(std::max(0.0, v));
}

std::vector<ComparedLayer> compared_layers(const History& history, const ImageU8& mask,
                                           const AppearanceOptions& options, const RunControl& control) {
  RunControl silent = control;
  silent.on_progress = nullptr;
  const HistoryFacts& facts = history.facts();
  std::vector<ComparedLayer> layers, constant;
  std::vector<std::size_t> of_frames;
  for (std::size_t m = 0; options.material_maps > 0.0 && m < kMaterialMaps.size(); ++m) {
    const std::string name(kMaterialMaps[m]);
    const bool is_of_frames =
        std::all_of(facts.frames.begin(), facts.frames.end(), [&](const FrameFacts& f) { return has(f.extras, name); });
    if (is_of_frames) {
      of_frames.push_back(m);
    } else if (has(facts.maps, name) && is_compared(name, false)) {
      constant.push_back({.read = [&history, name] { return history.read_map(name); },
                          .num_channels = static_cast<int>(history_map_channels(name).size()),
                          .material = m});
    }
  }
  for (const int frame : compared_frames(history.num_frames(), options.max_frames)) {
    layers.push_back({.read = [&history, frame] { return history.read_frame(frame); }, .num_channels = 3});
    for (const std::size_t m : of_frames) {
      const std::string name(kMaterialMaps[m]);
      layers.push_back(
          {.read = [&history, &mask, silent, frame, name] { return frame_map(history, frame, name, mask, silent); },
           .num_channels = static_cast<int>(frame_extra_channels(name).size()),
           .material = m});
    }
  }
  layers.insert(layers.end(), constant.begin(), constant.end());
  return layers;
}

void weigh_materials(std::vector<ComparedLayer>& layers, SampleMatrix& samples, double share) {
  std::array<double, kMaterialMaps.size()> variance{};
  double of_color = 0.0;
  Eigen::Index column = 0;
  for (const ComparedLayer& layer : layers) {
    for (int c = 0; c < layer.num_channels; ++c, ++column) {
      double mean = 0.0, sum = 0.0;
      for (Eigen::Index i = 0; i < samples.rows(); ++i) mean += samples(i, column);
      mean /= static_cast<double>(samples.rows());
      for (Eigen::Index i = 0; i < samples.rows(); ++i)
        sum += (samples(i, column) - mean) * (samples(i, column) - mean);
      (layer.material ? variance[*layer.material] : of_color) += sum;
    }
  }
  if (!(of_color > 0.0)) of_color = static_cast<double>(samples.rows());  // Counts as if they varied by 1.
  const auto num_kinds =
      static_cast<double>(std::count_if(variance.begin(), variance.end(), [](double v) { return v > 0.0; }));
  column = 0;
  for (ComparedLayer& layer : layers) {
    const double own = layer.material ? variance[*layer.material] : 0.0;
    if (layer.material) layer.weight = own > 0.0 ? std::min(1.0, std::sqrt(share * of_color / (num_kinds * own))) : 0.0;
    for (int c = 0; c < layer.num_channels; ++c, ++column) {
      if (!layer.material) continue;
      for (Eigen::Index i = 0; i < samples.rows(); ++i) samples(i, column) *= layer.weight;
    }
  }
}

}  // namespace patinate::transfer
