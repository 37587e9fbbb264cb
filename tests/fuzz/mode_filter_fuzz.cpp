#include <cmath>

#include "patinate/capture/thickness.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(mode_filter) {
  fuzz::ByteSource source(bytes);
  capture::ModeFilterOptions options;
  options.spatial_sigma_px = 0.5 + source.integer(0, 2000) / 20.0;
  options.range_sigma = static_cast<double>(std::abs(source.number()));
  options.num_bins = source.integer(16, 64);
  ImageF image(source.integer(1, 24), source.integer(1, 24));
  ImageU8 mask(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image.at(x, y) = source.number();
      mask.at(x, y) = source.byte() < 200 ? 255 : 0;
    }
  }
  RunControl control;
  control.num_threads = 1;
  const ImageF result = capture::mode_filter(image, mask, options, control);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      fuzz::require(mask.at(x, y) == 0 || std::isfinite(result.at(x, y)), "results are finite inside the mask");
    }
  }
}
