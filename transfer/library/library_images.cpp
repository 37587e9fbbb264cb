#include "transfer/library/library_images.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/history/history_sampling.h"

namespace patinate::transfer {

namespace {

ImageF resampled(const ImageF& image, int width, int height) {
  if (image.width() == width && image.height() == height) return image;
  return width <= image.width() && height <= image.height() ? downscale_area(image, width, height)
                                                            : resize_bilinear(image, width, height);
}

/// All that a pixel is made of is inside, but for rounding.
ImageU8 resampled_mask(const ImageU8& mask, int width, int height) {
  if (mask.width() == width && mask.height() == height) return mask;
  ImageF share(mask.width(), mask.height());
  std::transform(mask.values().begin(), mask.values().end(), share.values().begin(),
                 [](std::uint8_t m) { return m != 0 ? 1.0f : 0.0f; });
  share = resampled(share, width, height);
  ImageU8 out(width, height);
  std::transform(share.values().begin(), share.values().end(), out.values().begin(),
                 [](float s) { return static_cast<std::uint8_t>(s > 0.9999f ? 255 : 0); });
  return out;
}

/// By column of the library: the nearest part.
std::vector<std::size_t> nearest_parts(const LibraryLayout& layout) {
  std::vector<std::size_t> nearest(static_cast<std::size_t>(layout.width));
  std::size_t part = 0;
  for (int x = 0; x < layout.width; ++x) {
    while (part + 1 < layout.parts.size()) {
      const int end = layout.parts[part].x + layout.parts[part].width;
      if (2 * x < end - 1 + layout.parts[part + 1].x) break;
      ++part;
    }
    nearest[x] = part;
  }
  return nearest;
}

void check_count(const LibraryLayout& layout, std::size_t count) {
  if (count != layout.parts.size())
    throw InvalidInput("library: " + std::to_string(count) + " images for " + std::to_string(layout.parts.size()) +
                       " histories");
}

ImageF blend(ImageF image, const ImageF& next, float fraction) {
  const auto to = image.values();
  const auto from = next.values();
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = (1.0f - fraction) * to[i] + fraction * from[i];
  return image;
}

double time_of(const HistoryReader& reader, const TimePosition& at) {
  const auto& frames = reader.manifest().frames;
  const double time = frames[at.index].time;
  return at.fraction == 0.0
             ? time
             : (1.0 - at.fraction) * time + at.fraction * frames[static_cast<std::size_t>(at.index) + 1].time;
}

bool has_map(const HistoryReader& reader, MaterialMap map) {
  const std::vector<MaterialMap> maps = material_maps(reader.facts());
  return std::find(maps.begin(), maps.end(), map) != maps.end();
}

void make_unit(ImageF& normals) {
  for (int y = 0; y < normals.height(); ++y) {
    for (int x = 0; x < normals.width(); ++x) {
      Eigen::Map<Eigen::Vector3f> n(normals.pixel(x, y).data());
      const float length = n.norm();
      n = length > 1e-6f ? Eigen::Vector3f(n / length) : Eigen::Vector3f(0.0f, 0.0f, 1.0f);
    }
  }
}

ImageF extra_of(const HistoryReader& reader, const TimePosition& at, const std::string& name) {
  const HistoryManifest& m = reader.manifest();
  const double time = time_of(reader, at);
  const auto sample = [&](MaterialMap map) { return sample_material_map(reader, map, time, Between::Blend); };
  if (name == "normal") {
    if (has_map(reader, MaterialMap::Normal)) return sample(MaterialMap::Normal);
    ImageF upright(m.width, m.height, 3);
    make_unit(upright);
    return upright;
  }
  if (name == "height")
    return has_map(reader, MaterialMap::Height) ? sample(MaterialMap::Height) : ImageF(m.width, m.height);
  if (name == "metalness")
    return has_map(reader, MaterialMap::Metalness) ? sample(MaterialMap::Metalness) : ImageF(m.width, m.height);
  if (name == "tint")
    return has_map(reader, MaterialMap::Tint) ? sample(MaterialMap::Tint) : ImageF(m.width, m.height, 3);
  ImageF specular(m.width, m.height, 2);
  if (!has_map(reader, MaterialMap::Specular)) return specular;
  const ImageF strength = sample(MaterialMap::Specular), roughness = sample(MaterialMap::Roughness);
  for (std::size_t i = 0; i < strength.values().size(); ++i) {
    specular.values()[2 * i] = strength.values()[i];
    specular.values()[2 * i + 1] = roughness.values()[i];
  }
  return specular;
}

}  // namespace

ImageF lay_side_by_side(const LibraryLayout& layout, std::span<const ImageF> images) {
  check_count(layout, images.size());
  std::vector<ImageF> fitted;
  for (std::size_t p = 0; p < images.size(); ++p) {
    if (images[p].channels() != images[0].channels()) throw InvalidInput("library: images of different channels");
    fitted.push_back(resampled(images[p], layout.parts[p].width, layout.parts[p].height));
  }
  const std::vector<std::size_t> nearest = nearest_parts(layout);
  ImageF out(layout.width, layout.height, images[0].channels());
  for (int y = 0; y < layout.height; ++y) {
    for (int x = 0; x < layout.width; ++x) {
      const std::size_t p = nearest[x];
      const LibraryPart& part = layout.parts[p];
      const auto from =
          std::as_const(fitted[p]).pixel(std::clamp(x - part.x, 0, part.width - 1), std::min(y, part.height - 1));
      std::copy(from.begin(), from.end(), out.pixel(x, y).begin());
    }
  }
  return out;
}

ImageU8 lay_masks_side_by_side(const LibraryLayout& layout, std::span<const ImageU8> masks) {
  check_count(layout, masks.size());
  ImageU8 out(layout.width, layout.height);
  for (std::size_t p = 0; p < masks.size(); ++p) {
    const LibraryPart& part = layout.parts[p];
    const ImageU8 fitted = resampled_mask(masks[p], part.width, part.height);
    for (int y = 0; y < part.height; ++y) {
      const auto from = fitted.row(y);
      std::copy(from.begin(), from.end(), out.row(y).begin() + part.x);
    }
  }
  return out;
}

ImageF library_index_image(const LibraryLayout& layout) {
  const std::vector<std::size_t> nearest = nearest_parts(layout);
  ImageF out(layout.width, layout.height);
  for (int y = 0; y < layout.height; ++y) {
    for (int x = 0; x < layout.width; ++x) out.at(x, y) = static_cast<float>(nearest[x]);
  }
  return out;
}

ImageF library_frame(const LibraryLayout& layout, std::span<const HistoryReader> readers, const LibraryFrame& frame) {
  std::vector<ImageF> images;
  for (std::size_t p = 0; p < readers.size(); ++p) {
    const TimePosition& at = frame.at[p];
    ImageF image = readers[p].read_frame(at.index);
    if (at.fraction != 0.0)
      image = blend(std::move(image), readers[p].read_frame(at.index + 1), static_cast<float>(at.fraction));
    images.push_back(std::move(image));
  }
  return lay_side_by_side(layout, images);
}

ImageU8 library_frame_mask(const LibraryLayout& layout, std::span<const HistoryReader> readers,
                           const LibraryFrame& frame) {
  std::vector<ImageU8> masks;
  for (std::size_t p = 0; p < readers.size(); ++p) {
    const TimePosition& at = frame.at[p];
    masks.push_back(readers[p].read_frame_mask(at.index));
    if (at.fraction == 0.0) continue;
    const ImageU8 next = readers[p].read_frame_mask(at.index + 1);
    const auto to = masks.back().values();
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = std::min(to[i], next.values()[i]);
  }
  return lay_masks_side_by_side(layout, masks);
}

ImageF library_control(const LibraryLayout& layout, std::span<const HistoryReader> readers,
                       const LibraryControl& control) {
  std::vector<ImageF> images;
  for (std::size_t p = 0; p < readers.size(); ++p) {
    ImageF values = readers[p].read_control(control.sources[p]);
    const ControlFacts& own = readers[p].control(control.sources[p]);
    const bool is_same = control.has_own_ranges || (own.low == control.low && own.high == control.high);
    const double span = control.high - control.low;
    for (float& v : values.values()) {
      if (is_same) continue;
      const double physical = own.low + static_cast<double>(v) * (own.high - own.low);
      v = static_cast<float>(
          std::clamp((physical - control.low) / span, 0.0, 1.0));  // Ranges differ, so that span > 0.
    }
    images.push_back(std::move(values));
  }
  return lay_side_by_side(layout, images);
}

std::vector<std::string> library_extras(std::span<const HistoryReader> readers) {
  const auto any = [&](MaterialMap map) {
    return std::any_of(readers.begin(), readers.end(), [&](const HistoryReader& r) { return has_map(r, map); });
  };
  std::vector<std::string> names;
  if (any(MaterialMap::Specular)) names.emplace_back("specular");
  if (any(MaterialMap::Normal)) names.emplace_back("normal");
  if (any(MaterialMap::Height)) names.emplace_back("height");
  if (any(MaterialMap::Metalness)) names.emplace_back("metalness");
  if (any(MaterialMap::Tint)) names.emplace_back("tint");
  return names;
}

ImageF library_extra(const LibraryLayout& layout, std::span<const HistoryReader> readers, const LibraryFrame& frame,
                     const std::string& name) {
  std::vector<ImageF> images;
  for (std::size_t p = 0; p < readers.size(); ++p) images.push_back(extra_of(readers[p], frame.at[p], name));
  bool is_resampled = false;
  for (std::size_t p = 0; p < images.size(); ++p)
    is_resampled =
        is_resampled || images[p].width() != layout.parts[p].width || images[p].height() != layout.parts[p].height;
  ImageF out = lay_side_by_side(layout, images);
  if (name == "normal" && is_resampled) make_unit(out);
  return out;
}

}  // namespace patinate::transfer
