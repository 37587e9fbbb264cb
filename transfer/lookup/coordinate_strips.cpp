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
      source_height_(source_height) {
  std::vector<Kind> kinds{kPixels};
  if (options.is_subpixel) kinds.push_back(kBeside);
  if (options.with_turns) {
    const std::vector<std::string> there = probe_image(file_).channels;
    if (std::all_of(std::begin(kPatchChannels), std::end(kPatchChannels),
                    [&](const char* name) { return std::find(there.begin(), there.end(), name) != there.end(); }))
      kinds.push_back(kTurns);
  }
  const bool is_kept = std::int64_t{width} * height <= options.kept_texels;
  for (const Kind kind : kinds) {
    layers_[kind].emplace(Layer{GutterFill(width, height, rows_of_strip(options.strip_texels, width))});
    if (is_kept) layers_[kind]->kept = Image<std::uint32_t>(width, height);
  }
  ImageRowReader file_rows(file_, channels());
  if (file_rows.width() != width_ || file_rows.height() != height_) {
    throw IoError(file_.string(), "is " + size_text(file_rows.width(), file_rows.height()) + "; expected " +
                                      size_text(width_, height_));
  }
  Room room;
  bool is_between = false;
  const int num_strips = layers_[kPixels]->gutters.num_strips();
  for (int s = 0; s < num_strips; ++s) {
    control.throw_if_stopped();
    const Rows rows = rows_in(room, s);
    is_between = read(file_rows, s, rows) || is_between;
    for (const Kind kind : kinds) {
      Layer& layer = *layers_[kind];
      layer.gutters.look(rows[kind]);
      if (is_kept) std::copy(rows[kind].begin(), rows[kind].end(), layer.kept.row(layer.gutters.begin(s)).data());
    }
    control.report((s + 1.0) / num_strips);
  }
  if (!is_between) layers_[kBeside].reset();
  if (!is_kept) return;
  for (std::optional<Layer>& layer : layers_) {
    GutterFill::Sweep sweep;
    for (int s = 0; layer && s < num_strips; ++s) {
      const std::span<std::uint32_t> rows(layer->kept.row(layer->gutters.begin(s)).data(), strip_size(s));
      layer->gutters.fill(rows, sweep, control);
    }
  }
}

std::vector<std::string> CoordinateStrips::channels() const {
  std::vector<std::string> names{kCoordinateChannels[0], kCoordinateChannels[1]};
  if (layers_[kTurns]) names.insert(names.end(), std::begin(kPatchChannels), std::end(kPatchChannels));
  return names;
}

std::size_t CoordinateStrips::strip_size(int strip) const {
  const GutterFill& gutters = layers_[kPixels]->gutters;
  return static_cast<std::size_t>(gutters.end(strip) - gutters.begin(strip)) * static_cast<std::size_t>(width_);
}

CoordinateStrips::Rows CoordinateStrips::rows_in(Room& room, int strip) const {
  Rows rows;
  for (std::size_t kind = 0; kind < kNumKinds; ++kind) {
    if (!layers_[kind]) continue;
    room[kind].resize(strip_size(0));
    rows[kind] = std::span(room[kind]).first(strip_size(strip));
  }
  return rows;
}

bool CoordinateStrips::read(ImageRowReader& file, int strip, const Rows& rows) const {
  constexpr int kRows = 16;  // Rows that EXR compresses together.
  const GutterFill& gutters = layers_[kPixels]->gutters;
  std::vector<float> pair;
  const auto pick = [&](const ImageF& values, std::size_t first) {
    const auto channels = static_cast<std::size_t>(values.channels());
    pair.resize(2 * static_cast<std::size_t>(values.num_pixels()));
    for (std::size_t i = 0; i < pair.size(); ++i) pair[i] = values.data()[i / 2 * channels + first + i % 2];
  };
  bool is_between = false;
  for (int y = gutters.begin(strip); y < gutters.end(strip); y += kRows) {
    const int end = std::min(y + kRows, gutters.end(strip));
    const ImageF values = file.read(y, end);
    const auto offset = static_cast<std::size_t>(y - gutters.begin(strip)) * static_cast<std::size_t>(width_);
    const auto part = [&](Kind kind) {
      return rows[kind].empty() ? rows[kind]
                                : rows[kind].subspan(offset, static_cast<std::size_t>(values.num_pixels()));
    };
    pick(values, 0);
    is_between =
        pack_checked_rows(file_, pair, y, width_, source_width_, source_height_, part(kPixels), part(kBeside)) ||
        is_between;
    if (rows[kTurns].empty()) continue;
    pick(values, 2);
    pack_checked_turns(file_, pair, y, width_, part(kPixels), part(kTurns));
  }
  return is_between;
}

void CoordinateStrips::visit(const Visitor& visitor, const RunControl& control) const {
  const RunControl quiet = control.silent();
  std::array<GutterFill::Sweep, kNumKinds> sweeps;
  std::unique_ptr<ImageRowReader> file_rows;
  Room room;
  if (layers_[kPixels]->kept.empty()) {
    file_rows = std::make_unique<ImageRowReader>(file_, channels());
    if (file_rows->width() != width_ || file_rows->height() != height_)
      throw IoError(file_.string(), "has changed meanwhile; try again");
  }
  const int num_strips = layers_[kPixels]->gutters.num_strips();
  for (int s = 0; s < num_strips; ++s) {
    control.throw_if_stopped();
    std::array<std::span<const std::uint32_t>, kNumKinds> shown;
    if (file_rows) {
      const Rows rows = rows_in(room, s);
      read(*file_rows, s, rows);
      for (std::size_t kind = 0; kind < kNumKinds; ++kind) {
        if (layers_[kind]) layers_[kind]->gutters.fill(rows[kind], sweeps[kind], quiet);
        shown[kind] = rows[kind];
      }
    } else {
      for (std::size_t kind = 0; kind < kNumKinds; ++kind) {
        if (layers_[kind])
          shown[kind] = {layers_[kind]->kept.row(layers_[kind]->gutters.begin(s)).data(), strip_size(s)};
      }
    }
    visitor(layers_[kPixels]->gutters.begin(s), {shown[kPixels], shown[kBeside]}, shown[kTurns]);
    control.report((s + 1.0) / num_strips);
  }
}

}  // namespace patinate::transfer
