#include "transfer/lookup/coordinate_strips.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_io.h"
#include "transfer/files/flow_io.h"
#include "transfer/lookup/source_turn.h"

namespace patinate::transfer {

namespace {

/// A multiple of 64, in which EXR and TIFF keep rows together.
int rows_of_strip(std::int64_t strip_texels, int width) {
  constexpr std::int64_t kTogether = 64;
  return static_cast<int>(std::clamp<std::int64_t>(strip_texels / std::max(width, 1) / kTogether, 1, 1024) * kTogether);
}

}  // namespace

CoordinateStrips::CoordinateStrips(std::filesystem::path file, int width, int height, int source_width,
                                   int source_height, const CoordinateStripsOptions& options, const RunControl& control)
    : file_(std::move(file)),
      width_(width),
      height_(height),
      source_width_(source_width),
      source_height_(source_height),
      gutters_(width, height, rows_of_strip(options.strip_texels, width)) {
  if (options.with_turns) {
    const std::vector<std::string> there = probe_image(file_).channels;
    has_turns_ = std::all_of(std::begin(kPatchChannels), std::end(kPatchChannels), [&](const char* name) {
      return std::find(there.begin(), there.end(), name) != there.end();
    });
    if (has_turns_) turn_gutters_.emplace(width, height, gutters_.end(0));
  }
  ImageRowReader rows(file_, channels());
  if (rows.width() != width_ || rows.height() != height_) {
    throw IoError(file_.string(),
                  "is " + size_text(rows.width(), rows.height()) + "; expected " + size_text(width_, height_));
  }
  const bool is_kept = std::int64_t{width} * height <= options.kept_texels;
  if (is_kept) kept_ = PackedCoordinates(width, height);
  if (is_kept && has_turns_) kept_turns_ = Image<std::uint32_t>(width, height);
  std::vector<std::uint32_t> strip(is_kept ? 0 : strip_size(0)), turn_strip(is_kept || !has_turns_ ? 0 : strip_size(0));
  const auto rows_of = [&](Image<std::uint32_t>& kept, std::vector<std::uint32_t>& one, int s) {
    return is_kept ? std::span(kept.row(gutters_.begin(s)).data(), strip_size(s)) : std::span(one).first(strip_size(s));
  };
  for (int s = 0; s < gutters_.num_strips(); ++s) {
    control.throw_if_stopped();
    const std::span<std::uint32_t> indices = rows_of(kept_, strip, s);
    const std::span<std::uint32_t> turns =
        has_turns_ ? rows_of(kept_turns_, turn_strip, s) : std::span<std::uint32_t>();
    read(rows, s, indices, turns);
    gutters_.look(indices);
    if (has_turns_) turn_gutters_->look(turns);
    control.report((s + 1.0) / gutters_.num_strips());
  }
  if (!is_kept) return;
  GutterFill::Sweep sweep, turn_sweep;
  for (int s = 0; s < gutters_.num_strips(); ++s) {
    gutters_.fill(rows_of(kept_, strip, s), sweep, control);
    if (has_turns_) turn_gutters_->fill(rows_of(kept_turns_, turn_strip, s), turn_sweep, control);
  }
}

std::vector<std::string> CoordinateStrips::channels() const {
  std::vector<std::string> names{kCoordinateChannels[0], kCoordinateChannels[1]};
  if (has_turns_) names.insert(names.end(), std::begin(kPatchChannels), std::end(kPatchChannels));
  return names;
}

std::size_t CoordinateStrips::strip_size(int strip) const {
  return static_cast<std::size_t>(gutters_.end(strip) - gutters_.begin(strip)) * static_cast<std::size_t>(width_);
}

void CoordinateStrips::read(ImageRowReader& file, int strip, std::span<std::uint32_t> indices,
                            std::span<std::uint32_t> turns) const {
  constexpr int kRows = 16;  // What EXR compresses together.
  std::vector<float> pair;
  const auto pick = [&](const ImageF& values, std::size_t first) {
    const auto channels = static_cast<std::size_t>(values.channels());
    pair.resize(2 * static_cast<std::size_t>(values.num_pixels()));
    for (std::size_t i = 0; i < pair.size(); ++i) pair[i] = values.data()[i / 2 * channels + first + i % 2];
  };
  for (int y = gutters_.begin(strip); y < gutters_.end(strip); y += kRows) {
    const int end = std::min(y + kRows, gutters_.end(strip));
    const ImageF values = file.read(y, end);
    const auto offset = static_cast<std::size_t>(y - gutters_.begin(strip)) * static_cast<std::size_t>(width_);
    const auto rows = indices.subspan(offset, static_cast<std::size_t>(values.num_pixels()));
    pick(values, 0);
    pack_checked_rows(file_, pair, y, width_, source_width_, source_height_, rows);
    if (!has_turns_) continue;
    pick(values, 2);
    pack_checked_turns(file_, pair, y, width_, rows, turns.subspan(offset, rows.size()));
  }
}

void CoordinateStrips::visit(const Visitor& visitor, const RunControl& control) const {
  RunControl quiet = control;
  quiet.on_progress = {};
  GutterFill::Sweep sweep, turn_sweep;
  std::unique_ptr<ImageRowReader> rows;
  std::vector<std::uint32_t> strip, turn_strip;
  if (kept_.empty()) {
    rows = std::make_unique<ImageRowReader>(file_, channels());
    if (rows->width() != width_ || rows->height() != height_)
      throw IoError(file_.string(), "has changed meanwhile; try again");
    strip.resize(strip_size(0));
    turn_strip.resize(has_turns_ ? strip_size(0) : 0);
  }
  for (int s = 0; s < gutters_.num_strips(); ++s) {
    control.throw_if_stopped();
    if (rows) {
      const std::span<std::uint32_t> indices = std::span(strip).first(strip_size(s));
      const std::span<std::uint32_t> turns = std::span(turn_strip).first(has_turns_ ? strip_size(s) : 0);
      read(*rows, s, indices, turns);
      gutters_.fill(indices, sweep, quiet);
      if (has_turns_) turn_gutters_->fill(turns, turn_sweep, quiet);
      visitor(gutters_.begin(s), indices, turns);
    } else {
      const auto kept_rows = [&](const Image<std::uint32_t>& kept) {
        return std::span(kept.row(gutters_.begin(s)).data(), strip_size(s));
      };
      visitor(gutters_.begin(s), kept_rows(kept_),
              has_turns_ ? kept_rows(kept_turns_) : std::span<const std::uint32_t>());
    }
    control.report((s + 1.0) / gutters_.num_strips());
  }
}

}  // namespace patinate::transfer
