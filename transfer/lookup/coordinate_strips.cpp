#include "transfer/lookup/coordinate_strips.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "transfer/transfer_io.h"

namespace patinate {

namespace {

/// A multiple of 64, in which EXR and TIFF keep rows together.
int rows_of_strip(std::int64_t strip_texels, int width) {
  constexpr std::int64_t kTogether = 64;
  return static_cast<int>(std::clamp<std::int64_t>(strip_texels / std::max(width, 1) / kTogether, 1, 1024) * kTogether);
}

}  // namespace

CoordinateStrips::CoordinateStrips(std::filesystem::path file, int width, int height, int source_width, int source_height,
                                   const CoordinateStripsOptions& options, const RunControl& control)
    : file_(std::move(file)),
      width_(width),
      height_(height),
      source_width_(source_width),
      source_height_(source_height),
      gutters_(width, height, rows_of_strip(options.strip_texels, width)) {
  ImageRowReader rows(file_, {kCoordinateChannels[0], kCoordinateChannels[1]});
  if (rows.width() != width_ || rows.height() != height_) {
    throw IoError(file_.string(), "is " + size_text(rows.width(), rows.height()) + "; expected " + size_text(width_, height_));
  }
  const bool is_kept = std::int64_t{width} * height <= options.kept_texels;
  if (is_kept) kept_ = PackedCoordinates(width, height);
  std::vector<std::uint32_t> strip(is_kept ? 0 : strip_size(0));
  for (int s = 0; s < gutters_.num_strips(); ++s) {
    control.throw_if_stopped();
    const std::span<std::uint32_t> indices = is_kept ? std::span(kept_.row(gutters_.begin(s)).data(), strip_size(s)) : std::span(strip).first(strip_size(s));
    read(rows, s, indices);
    gutters_.look(indices);
    control.report((s + 1.0) / gutters_.num_strips());
  }
  if (!is_kept) return;
  GutterFill::Sweep sweep;
  for (int s = 0; s < gutters_.num_strips(); ++s) gutters_.fill(std::span(kept_.row(gutters_.begin(s)).data(), strip_size(s)), sweep, control);
}

std::size_t CoordinateStrips::strip_size(int strip) const {
  return static_cast<std::size_t>(gutters_.end(strip) - gutters_.begin(strip)) * static_cast<std::size_t>(width_);
}

void CoordinateStrips::read(ImageRowReader& file, int strip, std::span<std::uint32_t> indices) const {
  constexpr int kRows = 16;  // What EXR compresses together.
  for (int y = gutters_.begin(strip); y < gutters_.end(strip); y += kRows) {
    const int end = std::min(y + kRows, gutters_.end(strip));
    const ImageF xy = file.read(y, end);
    const auto offset = static_cast<std::size_t>(y - gutters_.begin(strip)) * static_cast<std::size_t>(width_);
    pack_checked_rows(file_, xy.values(), y, width_, source_width_, source_height_, indices.subspan(offset, static_cast<std::size_t>(xy.num_pixels())));
  }
}

void CoordinateStrips::visit(const Visitor& visitor, const RunControl& control) const {
  RunControl quiet = control;
  quiet.on_progress = {};
  GutterFill::Sweep sweep;
  std::unique_ptr<ImageRowReader> rows;
  std::vector<std::uint32_t> strip;
  if (kept_.empty()) {
    rows = std::make_unique<ImageRowReader>(file_, std::vector<std::string>{kCoordinateChannels[0], kCoordinateChannels[1]});
    if (rows->width() != width_ || rows->height() != height_) throw IoError(file_.string(), "has changed meanwhile; try again");
    strip.resize(strip_size(0));
  }
  for (int s = 0; s < gutters_.num_strips(); ++s) {
    control.throw_if_stopped();
    if (rows) {
      const std::span<std::uint32_t> indices = std::span(strip).first(strip_size(s));
      read(*rows, s, indices);
      gutters_.fill(indices, sweep, quiet);
      visitor(gutters_.begin(s), indices);
    } else {
      visitor(gutters_.begin(s), std::span(kept_.row(gutters_.begin(s)).data(), strip_size(s)));
    }
    control.report((s + 1.0) / gutters_.num_strips());
  }
}

}  // namespace patinate
