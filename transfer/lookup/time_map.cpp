#include "patinate/transfer/time_map.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/history/frame_locator.h"
#include "patinate/core/error.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate::transfer {

namespace {

/// Numbers of a pixel: one more than colors have, so that it is one register.
constexpr std::size_t kPadded = 4;

ImageF padded(const ImageF& frame) {
  ImageF out(frame.width(), frame.height(), static_cast<int>(kPadded));
  const float* from = frame.data();
  float* to = out.data();
  for (std::int64_t i = 0; i < frame.num_pixels(); ++i, from += 3, to += kPadded) std::copy_n(from, 3, to);
  return out;
}

/// Frames [first, first + size), each read when it is first asked for. Thread-safe.
class FrameBlock {
 public:
  FrameBlock(const History& history, int first, int size)
      : history_(history), first_(first), pixels_(static_cast<std::size_t>(size)), frames_(pixels_.size()) {}

  const float* operator[](int frame) {
    auto& pixels = pixels_[frame - first_];
    if (const float* known = pixels.load(std::memory_order_acquire)) return known;
    const std::lock_guard lock(mutex_);
    ImageF& image = frames_[frame - first_];
    if (image.empty()) image = padded(history_.read_frame(frame));
    pixels.store(image.data(), std::memory_order_release);
    return image.data();
  }

 private:
  const History& history_;
  int first_;
  std::mutex mutex_;
  std::vector<std::atomic<const float*>> pixels_;
  std::vector<ImageF> frames_;
};

[[noreturn]] void refuse_time(std::size_t x, int y) {
  throw InvalidInput("time map: texel (" + std::to_string(x) + ", " + std::to_string(y) +
                     ") has a time that is not a number");
}

/// Texels of one thread.
struct Texels {
  PlacesView places;
  std::span<const float> times;
  int first_row;  ///< First row of both.
  ImageF& result;
  int source_width, source_height;
  const FrameLocator& locate;
  FrameBlock& frames;
  int first, end;  ///< Frames that this block answers for.
  int hint = 0;
  int known = -1;  ///< Neighbors mostly lie between the same two.
  const float *before = nullptr, *after = nullptr;

  using Pixel = std::array<float, kPadded>;

  /// The color at a time, which pixels have before one looks between them.
  Pixel look(std::uint32_t pixel, BesidePixel beside, double fraction) const {
    const float share = static_cast<float>(fraction), rest = 1.0f - share;
    const auto blended = [&](std::size_t at) {
      Pixel color;
      for (std::size_t c = kPadded * at, i = 0; i < kPadded; ++c, ++i)
        color[i] = fraction == 0.0 ? before[c] : rest * before[c] + share * after[c];
      return color;
    };
    if (beside.is_middle()) return blended(pixel);
    const auto width = static_cast<std::uint32_t>(source_width);
    between_pixels::Block block;
    between_pixels::for_each_around(
        source_width, source_height, static_cast<int>(pixel % width), static_cast<int>(pixel / width), beside,
        [&](std::size_t k, std::size_t at) { block[k] = std::bit_cast<between_pixels::Lanes>(blended(at)); });
    return std::bit_cast<Pixel>(between_pixels::value_in(block, beside));
  }

  void look_up(int y) {
    const auto width = static_cast<std::size_t>(result.width());
    const PlacesView row = places.part(static_cast<std::size_t>(y) * width, width);
    const auto row_times = times.subspan(static_cast<std::size_t>(y) * width, width);
    const auto out = result.row(y);
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint32_t pixel = row.pixels[x];
      if (pixel == kNoValue) continue;
      if (std::isnan(row_times[x])) refuse_time(x, first_row + y);
      const TimePosition position = locate(static_cast<double>(row_times[x]), hint);
      hint = position.index;
      if (position.index < first || position.index >= end) continue;
      if (position.index != known) {
        known = position.index;
        before = frames[known];
        after = nullptr;
      }
      if (position.fraction != 0.0 && after == nullptr) after = frames[known + 1];
      const BesidePixel beside = row.beside.empty() ? BesidePixel{} : unpack_beside(row.beside[x]);
      const Pixel color = look(pixel, beside, position.fraction);
      std::copy_n(color.begin(), 3, out.data() + 3 * x);
    }
  }
};

}  // namespace

struct TimeMapLookup::Impl {
  const History& history;
  FrameLocator locate;
  int per_block;                         ///< Frames that are kept at once; one more for blends of a block's last one.
  std::unique_ptr<FrameBlock> all = {};  ///< Where that is all of them.

  Impl(const History& of, Between between, const TimeMapOptions& options) : history(of), locate(of.times(), between) {
    const std::int64_t bytes_per_frame = std::int64_t{history.facts().width} * history.facts().height *
                                         static_cast<std::int64_t>(kPadded * sizeof(float));
    per_block =
        static_cast<int>(std::clamp<std::int64_t>(options.frame_bytes / bytes_per_frame - 1, 1, history.num_frames()));
    if (per_block == history.num_frames()) all = std::make_unique<FrameBlock>(history, 0, per_block);
  }
};

TimeMapLookup::TimeMapLookup(const History& history, Between between, const TimeMapOptions& options)
    : impl_(std::make_unique<Impl>(history, between, options)) {}
TimeMapLookup::~TimeMapLookup() = default;

void TimeMapLookup::look_up(const PlacesView& places, std::span<const float> times, int first_row, ImageF& out,
                            const RunControl& control) {
  if (places.size() != times.size() || static_cast<std::int64_t>(places.size()) != out.num_pixels() ||
      out.channels() != 3) {
    throw InvalidInput("time map: expected one time for every texel of the coordinates");
  }
  std::fill(out.values().begin(), out.values().end(), 0.0f);
  const History& history = impl_->history;
  const RunControl quiet = control.silent();
  for (int first = 0; first < history.num_frames(); first += impl_->per_block) {
    const int end = std::min(history.num_frames(), first + impl_->per_block);
    std::unique_ptr<FrameBlock> some;
    if (!impl_->all)
      some = std::make_unique<FrameBlock>(history, first, std::min(history.num_frames(), end + 1) - first);
    FrameBlock& frames = impl_->all ? *impl_->all : *some;
    parallel_for(out.height(), 16, quiet, [&](std::int64_t from, std::int64_t to) {
      Texels texels{places,        times,  first_row, out, history.facts().width, history.facts().height,
                    impl_->locate, frames, first,     end};
      for (int y = static_cast<int>(from); y < static_cast<int>(to); ++y) texels.look_up(y);
    });
    control.report(static_cast<double>(end) / history.num_frames());
  }
}

ImageF gather_at_times(const History& history, const PackedPlaces& places, const ImageF& times, Between between,
                       const RunControl& control, const TimeMapOptions& options) {
  if (!times.same_size(places.pixels) || times.channels() != 1)
    throw InvalidInput("time map: expected one time for every texel of the coordinates");
  ImageF result(times.width(), times.height(), 3);
  TimeMapLookup(history, between, options).look_up(places.view(), times.values(), 0, result, control);
  return result;
}

ImageF gather_at_times(const History& history, const ImageF& coordinates, const ImageF& times, Between between,
                       const RunControl& control, const TimeMapOptions& options) {
  return gather_at_times(history, pack_coordinates(coordinates, history.facts().width, history.facts().height, control),
                         times, between, control, options);
}

}  // namespace patinate::transfer
