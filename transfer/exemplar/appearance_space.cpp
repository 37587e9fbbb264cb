#include "patinate/transfer/appearance_space.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/exemplar/compared_layers.h"
#include "transfer/exemplar/principal_components.h"
#include "transfer/exemplar/structure.h"

namespace patinate::transfer {

void describe(OptionVisitor& v, AppearanceOptions& o) {
  v.visit({"spatial_radius", "Radius of the neighborhood that describes a pixel's appearance", "px", between(0, 3)},
          o.spatial_radius_px);
  v.visit({"max_frames", "Longer histories are compared at this many evenly spaced frames", "", between(2, 128)},
          o.max_frames);
  v.visit({"appearance_samples", "Pixels from which the appearance components are found", "", between(64, 65536)},
          o.num_samples);
  v.visit({"material_maps",
           "Weight of gloss, metalness and relief relative to color, if the history has them; 0: ignore them", "",
           between(0, 10)},
          o.material_maps);
  v.visit(
      {"structure", "Weight of lines (such as cracks) and region borders relative to color; 0: do not look for them",
       "", between(0, 10)},
      o.structure);
  v.visit({"structure_map",
           "Control of the history that is high on lines, or on one of two materials; default: detect them"},
          o.structure_map);
}

std::vector<int> compared_frames(int num_frames, int max_frames) {
  std::vector<int> frames;
  const int count = std::min(num_frames, max_frames);
  for (int i = 0; i < count; ++i) {
    frames.push_back(count == 1 ? 0 : static_cast<int>(std::int64_t{i} * (num_frames - 1) / (count - 1)));
  }
  return frames;
}

namespace {

constexpr int kLook = 4096;  // Values between two looks at the stop.

RunControl quiet(const RunControl& control) {
  RunControl result = control;
  result.on_progress = nullptr;
  return result;
}

std::vector<std::int64_t> sample_pixels(const ImageU8& mask, int num_samples) {
  std::vector<std::int64_t> inside;
  for (std::int64_t p = 0; p < mask.num_pixels(); ++p) {
    if (mask.data()[p] != 0) inside.push_back(p);
  }
  if (inside.empty()) throw InvalidInput("the history's mask is empty: there is nothing to transfer");
  if (static_cast<std::int64_t>(inside.size()) <= num_samples) return inside;
  std::vector<std::int64_t> chosen;
  for (int i = 0; i < num_samples; ++i) {
    chosen.push_back(
        inside[RandomStream(0, static_cast<std::uint64_t>(i), 17).below(static_cast<std::uint32_t>(inside.size()))]);
  }
  return chosen;
}

/// H x W x 8: every pixel's colors, and what is known of its material, over time on the leading temporal components.
ImageF temporal_projection(const History& history, const ImageU8& mask, const AppearanceOptions& options,
                           double& explained, const RunControl& control) {
  std::vector<ComparedLayer> layers = compared_layers(history, mask, options, control);
  const auto num_layers = static_cast<double>(layers.size());
  const std::vector<std::int64_t> pixels = sample_pixels(mask, options.num_samples);
  Eigen::Index num_columns = 0;
  for (const ComparedLayer& layer : layers) num_columns += layer.num_channels;
  SampleMatrix samples(static_cast<Eigen::Index>(pixels.size()), num_columns);
  Eigen::Index column = 0;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    control.throw_if_stopped();
    const ImageF image = layers[l].read();
    for (int c = 0; c < layers[l].num_channels; ++c, ++column) {
      for (std::size_t i = 0; i < pixels.size(); ++i)
        samples(static_cast<Eigen::Index>(i), column) = layers[l].value(image, pixels[i], c);
    }
    control.report(0.4 * static_cast<double>(l + 1) / num_layers);
  }
  if (std::any_of(layers.begin(), layers.end(), [](const ComparedLayer& l) { return l.material.has_value(); }))
    weigh_materials(layers, samples, options.material_maps);
  const PrincipalComponents components = principal_components(samples, kAppearanceSize, quiet(control));
  explained = components.explained;

  ImageF projected(mask.width(), mask.height(), kAppearanceSize);
  column = 0;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const ComparedLayer& layer = layers[l];
    const ImageF image = layer.read();
    parallel_for(mask.height(), 16, quiet(control), [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t p = begin * mask.width(); p < end * mask.width(); ++p) {
        for (int c = 0; c < layer.num_channels; ++c) {
          const double value = layer.value(image, p, c) - components.mean[column + c];
          for (int k = 0; k < kAppearanceSize; ++k) {
            projected.data()[p * kAppearanceSize + k] += static_cast<float>(value * components.axes(column + c, k));
          }
        }
      }
    });
    column += layer.num_channels;
    control.report(0.4 + 0.5 * static_cast<double>(l + 1) / num_layers);
  }
  return projected;
}

/// Halves an image by averaging 2 x 2; a coarse pixel is inside when all four are.
void halve(const ImageF& image, const ImageU8& mask, ImageF& half, ImageU8& half_mask, const RunControl& control) {
  const int w = std::max(1, image.width() / 2), h = std::max(1, image.height() / 2);
  half = ImageF(w, h, image.channels());
  half_mask = ImageU8(w, h);
  for (int y = 0; y < h; ++y) {
    control.throw_if_stopped();
    for (int x = 0; x < w; ++x) {
      const int x1 = std::min(2 * x + 1, image.width() - 1), y1 = std::min(2 * y + 1, image.height() - 1);
      const bool inside = mask.at(2 * x, 2 * y) && mask.at(x1, 2 * y) && mask.at(2 * x, y1) && mask.at(x1, y1);
      half_mask.at(x, y) = inside ? 255 : 0;
      for (int c = 0; c < image.channels(); ++c) {
        half.at(x, y, c) =
            0.25f * (image.at(2 * x, 2 * y, c) + image.at(x1, 2 * y, c) + image.at(2 * x, y1, c) + image.at(x1, y1, c));
      }
    }
  }
}

/// Tent weight of an offset, so that the pixel itself counts most.
double spatial_weight(int dx, int dy, int radius) {
  return (1.0 - std::abs(dx) / (radius + 1.0)) * (1.0 - std::abs(dy) / (radius + 1.0));
}

/// The weighted components of the pixels around (x, y), clamped at the image border: C (2r + 1)^2 numbers.
Eigen::VectorXd neighborhood_vector(const ImageF& image, int x, int y, int radius) {
  Eigen::VectorXd v(image.channels() * (2 * radius + 1) * (2 * radius + 1));
  Eigen::Index i = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const double weight = spatial_weight(dx, dy, radius);
      const auto pixel =
          image.pixel(std::clamp(x + dx, 0, image.width() - 1), std::clamp(y + dy, 0, image.height() - 1));
      for (float value : pixel) v[i++] = weight * static_cast<double>(value);
    }
  }
  return v;
}

ImageF spatial_projection(const ImageF& image, const ImageU8& mask, const AppearanceOptions& options,
                          const RunControl& control) {
  const int radius = options.spatial_radius_px;
  if (radius == 0 && image.channels() == kAppearanceSize) return image;
  const std::vector<std::int64_t> pixels = sample_pixels(mask, options.num_samples);
  const Eigen::Index size = image.channels() * (2 * radius + 1) * (2 * radius + 1);
  SampleMatrix samples(static_cast<Eigen::Index>(pixels.size()), size);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (i % kLook == 0) control.throw_if_stopped();
    samples.row(static_cast<Eigen::Index>(i)) = neighborhood_vector(image, static_cast<int>(pixels[i] % mask.width()),
                                                                    static_cast<int>(pixels[i] / mask.width()), radius);
  }
  const PrincipalComponents components = principal_components(samples, kAppearanceSize, quiet(control));
  ImageF projected(image.width(), image.height(), kAppearanceSize);
  parallel_for(image.height(), 8, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const Eigen::VectorXd v = neighborhood_vector(image, x, y, radius) - components.mean;
        for (int k = 0; k < kAppearanceSize; ++k) {
          double sum = 0.0;
          for (Eigen::Index i = 0; i < size; ++i) sum += components.axes(i, k) * v[i];
          projected.at(x, y, k) = static_cast<float>(sum);
        }
      }
    }
  });
  return projected;
}

/// Sum over components of their variance inside the mask.
double total_variance(const ImageF& image, const ImageU8& mask, const RunControl& control) {
  double total = 0.0;
  for (int k = 0; k < image.channels(); ++k) {
    double sum = 0.0, sum_squares = 0.0, count = 0.0;
    for (std::int64_t p = 0; p < mask.num_pixels(); ++p) {
      if (p % kLook == 0) control.throw_if_stopped();
      if (mask.data()[p] == 0) continue;
      const double value = static_cast<double>(image.data()[p * image.channels() + k]);
      sum += value;
      sum_squares += value * value;
      count += 1.0;
    }
    if (count > 0.0) total += std::max(0.0, sum_squares / count - (sum / count) * (sum / count));
  }
  return total;
}

/// Components and structure, whose variance becomes `share` of theirs.
ImageF with_structure(const ImageF& image, const SourceStructure& structure, const ImageU8& mask, double share,
                      const RunControl& control) {
  const double own = total_variance(image, mask, control), other = total_variance(structure.channels, mask, control);
  const auto scale = static_cast<float>(other > 0.0 ? std::sqrt(share * own / other) : 0.0);
  const int n = structure.channels.channels();
  ImageF result(image.width(), image.height(), image.channels() + n);
  for (std::int64_t p = 0; p < image.num_pixels(); ++p) {
    if (p % kLook == 0) control.throw_if_stopped();
    float* out = result.data() + p * result.channels();
    out = std::copy_n(image.data() + p * image.channels(), image.channels(), out);
    for (int c = 0; c < n; ++c) out[c] = scale * structure.channels.data()[p * n + c];
  }
  return result;
}

/// Integers in which the whole spread has a standard deviation of a third of the limit.
AppearanceImage quantize(const ImageF& image, double variance, double& quantized_variance, const RunControl& control) {
  const double scale = variance > 1e-20 ? kAppearanceLimit / (3.0 * std::sqrt(variance)) : 0.0;
  AppearanceImage result(image.width(), image.height(), image.channels());
  for (std::size_t i = 0; i < image.values().size(); ++i) {
    if (i % kLook == 0) control.throw_if_stopped();
    const double q = std::floor(static_cast<double>(image.values()[i]) * scale + 0.5);
    result.values()[i] = static_cast<std::int16_t>(std::clamp<double>(q, -kAppearanceLimit, kAppearanceLimit));
  }
  quantized_variance = variance * scale * scale;
  return result;
}

}  // namespace

AppearanceSpace build_appearance_space(const History& history, int num_levels, const AppearanceOptions& options,
                                       const RunControl& control, const ImageU8& given_mask) {
  check_ranges(options);
  AppearanceSpace space;
  ImageU8 mask = given_mask.empty() ? history.read_mask() : given_mask;
  ImageF projected = temporal_projection(history, mask, options, space.explained_variance, control.part(0.0, 0.8));
  if (options.structure > 0.0) {
    const SourceStructure structure = find_structure(history, mask, options, quiet(control));
    if (!structure.empty())
      projected = with_structure(projected, structure, mask, options.structure * structure.weight, control);
  }
  for (int level = 0; level < num_levels; ++level) {
    const bool has_inside =
        std::any_of(mask.values().begin(), mask.values().end(), [](std::uint8_t m) { return m != 0; });
    if (!has_inside) break;
    const ImageF appearance = spatial_projection(projected, mask, options, control.part(0.9, 0.9));
    double variance = 0.0;
    space.levels.push_back(quantize(appearance, total_variance(appearance, mask, control), variance, control));
    space.masks.push_back(mask);
    space.variances.push_back(variance);
    ImageF half;
    ImageU8 half_mask;
    halve(projected, mask, half, half_mask, control);
    projected = std::move(half);
    mask = std::move(half_mask);
  }
  control.report(1.0);
  return space;
}

AppearanceSpace appearance_of(const History& history, const AppearanceSource& source, int num_levels,
                              const AppearanceOptions& options, const RunControl& control, const ImageU8& given_mask) {
  return source ? source(num_levels, options, control, given_mask)
                : build_appearance_space(history, num_levels, options, control, given_mask);
}

}  // namespace patinate::transfer
