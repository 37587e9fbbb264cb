/// \file
/// An image as its file holds it, and what is made of it. Inside of image input only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "patinate/image/color.h"
#include "patinate/image/image.h"
#include "patinate/image/image_io.h"

namespace patinate {

/// All channels, color not multiplied by alpha.
struct DecodedImage {
  ImageF values;                      ///< Codes scaled to [0, 1], or the file's values.
  std::vector<std::string> channels;  ///< Channels as stored, e.g. "R", "G", "B", "A".
  bool is_integer = true;             ///< Codes, which mean light only through a response; false: values are linear.
  std::string color_layer = {};       ///< Same as in ImageInfo; so are the others.
  std::shared_ptr<const ColorEncoding> encoding = {};
  std::string color_problem = {};
};

/// Whether a channel of an EXR is what R, G, B or A ("Red", "g") of the layer is.
[[nodiscard]] bool is_color_channel(const std::string& name, const std::string& layer, const std::string& color);
/// Position of a channel, -1 if it is not there. R, G, B and A are also found in the layer of the color.
[[nodiscard]] int channel_index(const DecodedImage& image, const std::string& name);
/// Color as 3 linear channels; gray is repeated, alpha dropped. `response` is applied to codes only, and in the place
/// of an encoding where it is not Response::Kind::File.
[[nodiscard]] ImageF color_of(const DecodedImage& image, const Response& response);
/// One channel. @throws InvalidInput if it is not there.
[[nodiscard]] ImageF channel_of(const DecodedImage& image, const std::string& name);
/// "Y", the only channel, or the mean of R, G, B.
[[nodiscard]] ImageF gray_of(const DecodedImage& image);

}  // namespace patinate
