#include "transfer/lookup/time_map.h"

#include <cstdint>
#include <optional>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/core/parallel.h"

namespace patinate {

namespace {

/// Texels sorted by the frame at or before their time: those of frame i are texels[first[i]] to texels[first[i + 1] - 1].
struct TexelsByFrame {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> texels;
};

TexelsByFrame sort_texels(const HistoryReader& history, const ImageF& coordinates, const ImageF& times, Between between) {
  TexelsByFrame sorted;
  sorted.first.assign(static_cast<std::size_t>(history.num_frames()) + 1, 0);
  const auto num_texels = static_cast<std::size_t>(coordinates.num_pixels());
  std::vector<int> frame(num_texels, -1);
  for (std::size_t i = 0; i < num_texels; ++i) {
    if (coordinates.data()[2 * i] < 0.0f) continue;
    frame[i] = locate(history, times.data()[i], between).index;
    ++sorted.first[static_cast<std::size_t>(frame[i]) + 1];
  }
  for (std::size_t f = 1; f < sorted.first.size(); ++f) sorted.first[f] += sorted.first[f - 1];
  sorted.texels.resize(sorted.first.back());
  std::vector<std::size_t> next = sorted.first;
  for (std::size_t i = 0; i < num_texels; ++i) {
    if (frame[i] >= 0) sorted.texels[next[static_cast<std::size_t>(frame[i])]++] = static_cast<std::uint32_t>(i);
  }
  return sorted;
}

}  // namespace

ImageF gather_at_times(const HistoryReader& history, const ImageF& coordinates, const ImageF& times, Between between,
                       const RunControl& control) {
  if (!times.same_size(coordinates) || coordinates.channels() != 2 || times.channels() != 1) {
    throw InvalidInput("time map: expected one time for every texel of the coordinates");
  }
  const TexelsByFrame sorted = sort_texels(history, coordinates, times, between);
  ImageF result(coordinates.width(), coordinates.height(), 3);
  ImageF here, after;
  int index_after = -1;
  RunControl quiet = control;
  quiet.on_progress = {};
  for (int f = 0; f < history.num_frames(); ++f) {
    const std::size_t begin = sorted.first[static_cast<std::size_t>(f)], end = sorted.first[static_cast<std::size_t>(f) + 1];
    if (begin == end) continue;
    here = index_after == f ? std::move(after) : history.read_frame(f);
    after = {};
    index_after = -1;
    const bool is_last = f + 1 == history.num_frames();
    if (between == Between::Blend && !is_last) {
      after = history.read_frame(f + 1);
      index_after = f + 1;
    }
    constexpr std::int64_t kChunk = 1 << 15;
    parallel_for(static_cast<std::int64_t>(end - begin), kChunk, quiet, [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t k = from; k < to; ++k) {
        const std::size_t texel = sorted.texels[begin + static_cast<std::size_t>(k)];
        const int x = static_cast<int>(coordinates.data()[2 * texel]), y = static_cast<int>(coordinates.data()[2 * texel + 1]);
        const auto fraction = static_cast<float>(locate(history, times.data()[texel], between).fraction);
        for (int c = 0; c < 3; ++c) {
          const float value = here.at(x, y, c);
          result.data()[3 * texel + static_cast<std::size_t>(c)] =
              fraction == 0.0f ? value : (1.0f - fraction) * value + fraction * after.at(x, y, c);
        }
      }
    });
    control.report((f + 1.0) / history.num_frames());
  }
  return result;
}

}  // namespace patinate
