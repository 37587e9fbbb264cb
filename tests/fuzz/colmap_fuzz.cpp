#include "libcommon/geometry/camera_text_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

/// images.txt, then a line of `====`, then cameras.txt.
PATINATE_FUZZ_TARGET(colmap) {
  const std::string_view text = fuzz::text_of(bytes);
  const std::size_t cut = text.find("====\n");
  fuzz::fuzz_file("images.txt", bytes.first(cut == std::string_view::npos ? bytes.size() : cut));
  fuzz::fuzz_file("cameras.txt", cut == std::string_view::npos ? fuzz::Bytes() : bytes.subspan(cut + 5));
  const CameraParameters p = read_colmap_camera(fuzz::fuzz_folder(), "");
  fuzz::require(p.width >= 1 && p.width <= 65536, "a picture has a size");
}
