#include "analysis/factorization/map_pictures.h"

#include <algorithm>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

/// Three equal channels of a map that curve and maps have made.
ImageF made_map(const FactorizationWork& work, const fs::path& folder, std::size_t frame) {
  const QuantityPlace place = place_of(work.task.of);
  const ImageF all =
      read_channels(folder / "history" / HistoryWriter::frame_extra_file(static_cast<int>(frame), place.extra),
                    frame_extra_channels(place.extra));
  ImageF out(all.width(), all.height(), 3);
  for (std::int64_t i = 0; i < all.num_pixels(); ++i)
    std::fill_n(out.data() + 3 * i, 3, all.data()[i * all.channels() + place.channel]);
  return out;
}

}  // namespace

ImageF shown(ImageF image) {
  constexpr int kPictureSide = 256;
  const int longer = std::max(image.width(), image.height());
  if (longer <= kPictureSide) return image;
  return downscale_area(image, std::max(1, image.width() * kPictureSide / longer),
                        std::max(1, image.height() * kPictureSide / longer));
}

void add_map_strips(const FactorizationWork& work, const fs::path& folder, Section& section) {
  const std::string unit = work.task.of == FactorQuantity::Height ? " mm" : "",
                    time_unit = " " + shown_time_unit(work.history.manifest().time_unit);
  std::vector<ImageF> seen, made;
  std::vector<std::string> labels;
  double low = 1e300, high = -1e300;
  for (const std::size_t k : spread_indices(work.frames.size(), kPicturesInARow)) {
    const int source = work.frames[k].source;
    ImageF values = work.values().read_frame(source);
    const ImageU8 mask = work.values().read_frame_mask(source);
    for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
      if (mask.data()[i] == 0) continue;
      low = std::min(low, static_cast<double>(values.data()[3 * i]));
      high = std::max(high, static_cast<double>(values.data()[3 * i]));
    }
    seen.push_back(shown(std::move(values)));
    made.push_back(shown(made_map(work, folder, k)));
    labels.push_back(short_number_text(rounded(work.frames[k].time, 4)) + time_unit);
  }
  const double span = std::max(1e-9, high - low);
  const std::string range = ": " + short_number_text(rounded(low, 3)) + unit + " black, " +
                            short_number_text(rounded(high, 3)) + unit + " white";
  const auto strip = [&](const char* name, const std::string& caption, std::vector<ImageF>& images) {
    for (ImageF& image : images) {
      for (float& v : image.values())
        v = static_cast<float>(std::clamp((static_cast<double>(v) - low) / span, 0.0, 1.0));
    }
    section.pictures.push_back({name, caption + range, contact_strip(images, labels, {.label_px = 13})});
  };
  strip("history", "The history's " + name_of(work.task.of), seen);
  strip("factored", "Curve and maps", made);
}

}  // namespace patinate::analysis
