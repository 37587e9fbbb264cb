#include "transfer/lookup/time_map.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/core/parallel.h"

namespace patinate {

namespace {

/// Where and when a texel looks.
struct TexelTime {
  std::uint32_t texel;
  float fraction;  ///< Of the way to the next frame.
};

/// Texels sorted by the frame at or before their time: those of frame i are texels[first[i]] to texels[first[i + 1] - 1].
struct TexelsByFrame {
  std::vector<std::size_t> first;
  std::vector<TexelTime> texels;
};

TexelsByFrame sort_texels(const HistoryReader& history, const ImageF& coordinates, const ImageF& times, Between between,
                          const RunControl& control) {
  const auto num_texels = static_cast<std::size_t>(coordinates.num_pixels());
  std::vector<int> frame(num_texels, -1);
  std::vector<float> fraction(num_texels);
  constexpr std::int64_t kChunk = 1 << 16;
  parallel_for(coordinates.num_pixels(), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      if (coordinates.data()[2 * i] < 0.0f) continue;
      const TimePosition position = locate(history, times.data()[i], between);
      frame[i] = position.index;
      fraction[i] = static_cast<float>(position.fraction);
    }
  });
  TexelsByFrame sorted;
  sorted.first.assign(static_cast<std::size_t>(history.num_frames()) + 1, 0);
  for (int f : frame) {
    if (f >= 0) ++sorted.first[static_cast<std::size_t>(f) + 1];
  }
  for (std::size_t f = 1; f < sorted.first.size(); ++f) sorted.first[f] += sorted.first[f - 1];
  sorted.texels.resize(sorted.first.back());
  std::vector<std::size_t> next = sorted.first;
  for (std::size_t i = 0; i < num_texels; ++i) {
    if (frame[i] >= 0) sorted.texels[next[static_cast<std::size_t>(frame[i])]++] = {static_cast<std::uint32_t>(i), fraction[i]};
  }
  return sorted;
}

}  // namespace

ImageF gather_at_times(const HistoryReader& history, const ImageF& coordinates, const ImageF& times, Between between,
                       const RunControl& control) {
  if (!times.same_size(coordinates) || coordinates.channels() != 2 || times.channels() != 1) {
    throw InvalidInput("time map: expected one time for every texel of the coordinates");
  }
  ImageF result(coordinates.width(), coordinates.height(), 3);
  ImageF here, after;
  int index_after = -1;
  RunControl quiet = control;
  quiet.on_progress = {};
  const TexelsByFrame sorted = sort_texels(history, coordinates, times, between, quiet);
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
        const auto [texel, fraction] = sorted.texels[begin + static_cast<std::size_t>(k)];
        const float* s = coordinates.data() + 2 * std::size_t{texel};
        const std::int64_t pixel = static_cast<std::int64_t>(static_cast<int>(s[1])) * here.width() + static_cast<int>(s[0]);
        const float* a = here.data() + 3 * pixel;
        float* color = result.data() + 3 * std::size_t{texel};
        if (fraction == 0.0f) {
          std::copy_n(a, 3, color);
          continue;
        }
        const float* b = after.data() + 3 * pixel;
        for (int c = 0; c < 3; ++c) color[c] = (1.0f - fraction) * a[c] + fraction * b[c];
      }
    });
    control.report((f + 1.0) / history.num_frames());
  }
  return result;
}

}  // namespace patinate
