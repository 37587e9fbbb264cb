/// \file
/// Which part, view and layer of an EXR is its picture. Inside of image input only.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace Imf_3_1 {
class MultiPartInputFile;
}

namespace patinate {

/// A channel "layer.suffix", and where it stands among others.
struct ExrChannel {
  std::string name;   ///< In the file.
  std::string layer;  ///< With its dot.
  std::string suffix;
  std::size_t rank = 0;
};

struct ExrPicture {
  int part = 0;
  std::vector<ExrChannel>
      channels;            ///< All channels of that part; for luminance and chroma what they become: R, G, B and A.
  std::string layer;       ///< Layer of its color, with a dot; "" for channels without a layer.
  bool has_color = false;  ///< Red, green and blue.
  bool is_luminance_chroma = false;
  std::string text;     ///< "layer ViewLayer.Combined"; "" for a file of one part and one layer.
  std::string problem;  ///< Why its color is none that can be told; "" if it can.
};

/// The color without a layer; the only color there is; of several the one that renderers call the picture ("Combined",
/// "beauty", "rgba"). Of views the first. Without color the first part. @returns nothing for deep pixels and for what
/// only OpenImageIO reads.
[[nodiscard]] std::optional<ExrPicture> find_exr_picture(const Imf_3_1::MultiPartInputFile& file);

}  // namespace patinate
