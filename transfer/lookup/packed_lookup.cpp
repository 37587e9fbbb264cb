#include "transfer/lookup/packed_lookup.h"

#include <algorithm>
#include <array>
#include <atomic>
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
  constexpr std::size_t kRun = 8;  // Texels that are gathered at once; speed alone.
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

template <std::size_t kChannels>
void gather_between(const ImageF& source, const PlacesView& places, float outside, float* out) {
  const float* const pixels = source.data();
  const auto width = static_cast<std::uint32_t>(source.width());
  for (std::size_t i = 0; i < places.size(); ++i) {
    float* const to = out + kChannels * i;
    const std::uint32_t pixel = places.pixels[i];
    if (pixel == kNoValue) {
      std::fill_n(to, kChannels, outside);
      continue;
    }
    const BesidePixel beside = unpack_beside(places.beside[i]);
    if (beside.is_middle()) {
      std::copy_n(pixels + kChannels * std::size_t{pixel}, kChannels, to);
    } else {
      look_between<kChannels>(pixels, source.width(), source.height(), static_cast<int>(pixel % width),
                              static_cast<int>(pixel / width), beside, to);
    }
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

namespace {

/// A texel that cannot be packed, and what is wrong with it.
struct PackProblem {
  std::size_t texel;
  const char* text;
};

/// @param is_between  Set if a place is not the middle of its pixel.
std::optional<PackProblem> pack(std::span<const float> xy, int source_width, int source_height,
                                std::span<std::uint32_t> pixels, std::span<std::uint32_t> beside, bool& is_between) {
  const auto last_column = static_cast<float>(source_width - 1), last_row = static_cast<float>(source_height - 1);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const float x = xy[2 * i], y = xy[2 * i + 1];
    if (x == -1.0f && y == -1.0f) {
      pixels[i] = kNoValue;
      if (!beside.empty()) beside[i] = kNoValue;
      continue;
    }
    const bool is_inside = x >= 0.0f && y >= 0.0f && x <= last_column && y <= last_row;  // No NaN either.
    if (!is_inside) return PackProblem{i, "points outside the history"};
    const NearestPixel place = nearest_pixel(x, y);
    const bool is_middle = place.beside.is_middle() && x == std::floor(x) && y == std::floor(y);
    if (!is_middle && beside.empty()) return PackProblem{i, "points between the history's pixels"};
    is_between = is_between || !place.beside.is_middle();
    pixels[i] = static_cast<std::uint32_t>(place.y) * static_cast<std::uint32_t>(source_width) +
                static_cast<std::uint32_t>(place.x);
    if (!beside.empty()) beside[i] = pack_beside(place.beside);
  }
  return std::nullopt;
}

std::string text_of(const PackProblem& problem, int first_row, int width) {
  const auto w = static_cast<std::size_t>(width);
  return "texel (" + std::to_string(problem.texel % w) + ", " +
         std::to_string(static_cast<std::size_t>(first_row) + problem.texel / w) + ") " + problem.text;
}

}  // namespace

PackedPlaces pack_coordinates(const ImageF& coordinates, int source_width, int source_height,
                              const RunControl& control) {
  if (coordinates.channels() != 2 || !(source_width > 0) || !(source_height > 0))
    throw InvalidInput("coordinates: expected two numbers per texel, and a source with at least one pixel");
  PackedPlaces places{PackedCoordinates(coordinates.width(), coordinates.height()),
                      Image<std::uint32_t>(coordinates.width(), coordinates.height())};
  std::atomic<bool> is_any_between = false;
  parallel_for(coordinates.height(), 64, control.silent(), [&](std::int64_t begin, std::int64_t end) {
    bool is_between = false;
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const auto problem =
          pack(coordinates.row(y), source_width, source_height, places.pixels.row(y), places.beside.row(y), is_between);
      if (problem) throw InvalidInput("coordinates: " + text_of(*problem, y, coordinates.width()));
    }
    if (is_between) is_any_between = true;
  });
  if (!is_any_between) places.beside = {};
  return places;
}

void fill_sheet(Image<std::uint32_t>& values, const Sheet& sheet) {
  if (sheet.num_tiles() == 1) return fill_gutters(values);
  for (int i = 0; i < sheet.num_tiles(); ++i) {
    Image<std::uint32_t> tile = cut_tile(values, sheet, i);
    fill_gutters(tile);
    paste_tile(values, sheet, i, tile);
  }
}

PackedPlaces filled_places(const ImageF& coordinates, int source_width, int source_height, const Sheet& sheet) {
  PackedPlaces places = pack_coordinates(coordinates, source_width, source_height);
  fill_sheet(places.pixels, sheet);
  if (!places.beside.empty()) fill_sheet(places.beside, sheet);
  return places;
}

bool pack_checked_rows(const std::filesystem::path& file, std::span<const float> xy, int first_row, int width,
                       int source_width, int source_height, std::span<std::uint32_t> pixels,
                       std::span<std::uint32_t> beside) {
  bool is_between = false;
  if (const auto problem = pack(xy, source_width, source_height, pixels, beside, is_between))
    throw IoError(file.string(), text_of(*problem, first_row, width) + "; make the transfer again");
  return is_between;
}

void gather_packed(const ImageF& source, std::span<const std::uint32_t> indices, float outside, std::span<float> out) {
  gather_any<float>(source, indices, outside, out);
}
void gather_packed(const ImageU8& source, std::span<const std::uint32_t> indices, std::uint8_t outside,
                   std::span<std::uint8_t> out) {
  gather_any<std::uint8_t>(source, indices, outside, out);
}
void gather_packed(const ImageF& source, const PlacesView& places, float outside, std::span<float> out) {
  if (places.beside.empty()) return gather_packed(source, places.pixels, outside, out);
  if (out.size() != places.size() * static_cast<std::size_t>(source.channels()))
    throw InvalidInput("lookup: as many values are expected as texels have channels");
  switch (source.channels()) {
    case 1:
      return gather_between<1>(source, places, outside, out.data());
    case 2:
      return gather_between<2>(source, places, outside, out.data());
    case 3:
      return gather_between<3>(source, places, outside, out.data());
    case 4:
      return gather_between<4>(source, places, outside, out.data());
    default:
      throw InvalidInput("lookup: a source of " + std::to_string(source.channels()) + " channels; use 1 to 4");
  }
}
void make_unit_between(const PlacesView& places, std::span<float> xyz) {
  for (std::size_t i = 0; i < places.beside.size(); ++i) {
    if (places.pixels[i] == kNoValue || unpack_beside(places.beside[i]).is_middle()) continue;
    float* const n = &xyz[3 * i];
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int c = 0; c < 3 && length > 0.0f; ++c) n[c] /= length;
  }
}
ImageF gather_packed(const ImageF& source, const PackedPlaces& places, float outside, const RunControl& control) {
  if (places.beside.empty()) return gather_packed(source, places.pixels, outside, control);
  ImageF out(places.pixels.width(), places.pixels.height(), source.channels());
  parallel_for(out.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
      gather_packed(source, PlacesView{places.pixels.row(y), places.beside.row(y)}, outside, out.row(y));
  });
  return out;
}
ImageF gather_packed(const ImageF& source, const PackedCoordinates& indices, float outside, const RunControl& control) {
  return gather_image<float>(source, indices, outside, control);
}
ImageU8 gather_packed(const ImageU8& source, const PackedCoordinates& indices, std::uint8_t outside,
                      const RunControl& control) {
  return gather_image<std::uint8_t>(source, indices, outside, control);
}

}  // namespace patinate::transfer
