#include "transfer/lookup/packed_lookup.h"

#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

namespace {

/// Neighbors mostly look at neighbors: eight that do are one copy.
template <class T, std::size_t kChannels>
void gather_pixels(const T* source, std::span<const std::uint32_t> indices, T outside, T* out) {
  constexpr std::size_t kRun = 8;
  const auto one = [&](std::size_t i) {
    T* const to = out + kChannels * i;
    if (indices[i] == kNoValue) {
      for (std::size_t c = 0; c < kChannels; ++c) to[c] = outside;
      return;
    }
    const T* const from = source + kChannels * std::size_t{indices[i]};
    for (std::size_t c = 0; c < kChannels; ++c) to[c] = from[c];
  };
  std::size_t i = 0;
  for (; i + kRun <= indices.size(); i += kRun) {
    const std::uint32_t first = indices[i];
    std::uint32_t differs = 0;
    for (std::uint32_t k = 1; k < kRun; ++k) differs |= indices[i + k] - first - k;
    if (differs == 0) {
      std::memcpy(out + kChannels * i, source + kChannels * std::size_t{first}, kRun * kChannels * sizeof(T));
    } else {
      for (std::size_t k = i; k < i + kRun; ++k) one(k);
    }
  }
  for (; i < indices.size(); ++i) one(i);
}

template <class T>
void gather_any(const Image<T>& source, std::span<const std::uint32_t> indices, T outside, std::span<T> out) {
  if (out.size() != indices.size() * static_cast<std::size_t>(source.channels()))
    throw InvalidInput("lookup: as many values are expected as texels have channels");
  switch (source.channels()) {
    case 1:
      return gather_pixels<T, 1>(source.data(), indices, outside, out.data());
    case 2:
      return gather_pixels<T, 2>(source.data(), indices, outside, out.data());
    case 3:
      return gather_pixels<T, 3>(source.data(), indices, outside, out.data());
    case 4:
      return gather_pixels<T, 4>(source.data(), indices, outside, out.data());
    default:
      throw InvalidInput("lookup: a source of " + std::to_string(source.channels()) + " channels; use 1 to 4");
  }
}

template <class T>
Image<T> gather_image(const Image<T>& source, const PackedCoordinates& indices, T outside, const RunControl& control) {
  Image<T> out(indices.width(), indices.height(), source.channels());
  parallel_for(indices.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
      gather_any<T>(source, indices.row(y), outside, out.row(y));
  });
  return out;
}

}  // namespace

PackedCoordinates pack_coordinates(const ImageF& coordinates, int source_width, const RunControl& control) {
  if (coordinates.channels() != 2 || !(source_width > 0))
    throw InvalidInput("coordinates: expected two numbers a texel and a source");
  PackedCoordinates indices(coordinates.width(), coordinates.height());
  parallel_for(coordinates.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const auto from = coordinates.row(y);
      const auto to = indices.row(y);
      for (std::size_t x = 0; x < to.size(); ++x) {
        const bool is_outside = from[2 * x] < 0.0f;
        to[x] = is_outside ? kNoValue
                           : static_cast<std::uint32_t>(static_cast<std::int64_t>(from[2 * x + 1]) * source_width +
                                                        static_cast<std::int64_t>(from[2 * x]));
      }
    }
  });
  return indices;
}

namespace {

/// A texel that cannot be packed, and what is wrong with it.
struct PackProblem {
  std::size_t texel;
  const char* text;
};

std::optional<PackProblem> pack(std::span<const float> xy, int source_width, int source_height,
                                std::span<std::uint32_t> indices) {
  const auto source_w = static_cast<float>(source_width), source_h = static_cast<float>(source_height);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const float x = xy[2 * i], y = xy[2 * i + 1];
    if (x == -1.0f && y == -1.0f) {
      indices[i] = kNoValue;
      continue;
    }
    const bool is_inside = x >= 0.0f && y >= 0.0f && x < source_w && y < source_h;  // No NaN either.
    if (!is_inside) return PackProblem{i, "points outside the history"};
    const auto column = static_cast<std::int64_t>(x), row = static_cast<std::int64_t>(y);
    if (static_cast<float>(column) != x || static_cast<float>(row) != y)
      return PackProblem{i, "points between the history's pixels"};
    indices[i] = static_cast<std::uint32_t>(row * source_width + column);
  }
  return std::nullopt;
}

std::string text_of(const PackProblem& problem, int first_row, int width) {
  const auto w = static_cast<std::size_t>(width);
  return "texel (" + std::to_string(problem.texel % w) + ", " +
         std::to_string(static_cast<std::size_t>(first_row) + problem.texel / w) + ") " + problem.text;
}

}  // namespace

PackedCoordinates pack_checked_coordinates(const ImageF& coordinates, int source_width, int source_height,
                                           const RunControl& control) {
  if (coordinates.channels() != 2) throw InvalidInput("coordinates: expected two numbers a texel");
  PackedCoordinates indices(coordinates.width(), coordinates.height());
  RunControl silent = control;
  silent.on_progress = {};
  parallel_for(coordinates.height(), 64, silent, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const auto problem = pack(coordinates.row(y), source_width, source_height, indices.row(y));
      if (problem) throw InvalidInput("coordinates: " + text_of(*problem, y, coordinates.width()));
    }
  });
  return indices;
}

void pack_checked_rows(const std::filesystem::path& file, std::span<const float> xy, int first_row, int width,
                       int source_width, int source_height, std::span<std::uint32_t> indices) {
  if (const auto problem = pack(xy, source_width, source_height, indices))
    throw IoError(file.string(), text_of(*problem, first_row, width) + "; make the transfer again");
}

void gather_packed(const ImageF& source, std::span<const std::uint32_t> indices, float outside, std::span<float> out) {
  gather_any<float>(source, indices, outside, out);
}
void gather_packed(const ImageU8& source, std::span<const std::uint32_t> indices, std::uint8_t outside,
                   std::span<std::uint8_t> out) {
  gather_any<std::uint8_t>(source, indices, outside, out);
}
ImageF gather_packed(const ImageF& source, const PackedCoordinates& indices, float outside, const RunControl& control) {
  return gather_image<float>(source, indices, outside, control);
}
ImageU8 gather_packed(const ImageU8& source, const PackedCoordinates& indices, std::uint8_t outside,
                      const RunControl& control) {
  return gather_image<std::uint8_t>(source, indices, outside, control);
}

}  // namespace patinate::transfer
