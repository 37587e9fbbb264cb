/// \file
/// What a movie says of its colors, and how it is undone. Inside of media only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

struct AVCodecParameters;

namespace patinate {

/// From the codes of a movie whose light is not sRGB's to linear Rec. 709 light.
///
/// HLG: scene light by the inverse OETF [ITU-R BT.2100-2, table 5], 1 at the code 0.75. PQ: display light by the EOTF
/// [table 4], 1 at 203 cd/m2. Both ones are diffuse white [ITU-R BT.2408-7, table 1]. Other transfers as sRGB has them,
/// as everywhere. Light of colors outside of Rec. 709 is cut at 0.
class MovieLight {
 public:
  /// @param transfer,primaries  Their numbers in ITU-T H.273.
  MovieLight(int transfer, int primaries);
  /// @param codes  Of 16 bits; `channels` a pixel, 3 or 4: R, G, B, and alpha, which becomes a share.
  /// @param light  As many values.
  void convert(const std::uint16_t* codes, std::size_t num_pixels, int channels, float* light) const;

 private:
  std::vector<float> linear_;  ///< By code.
  double matrix_[9];           ///< Rec. 709 from the movie's primaries, row by row.
};

/// Nothing for a movie whose codes are as good as sRGB's: Rec. 601 and 709 and sRGB, or nothing said.
/// @throws InvalidInput naming a transfer, primaries or a matrix that cannot be undone.
[[nodiscard]] std::optional<MovieLight> movie_light(const AVCodecParameters& movie);
/// "HLG with BT.2020 colors, made linear Rec. 709"; "" for what movie_light() leaves alone.
[[nodiscard]] std::string movie_color_text(const AVCodecParameters& movie);

}  // namespace patinate
