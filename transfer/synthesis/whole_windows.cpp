#include "transfer/synthesis/whole_windows.h"

#include <vector>

namespace patinate::transfer {

std::int64_t num_whole_windows(const ImageU8& mask, int radius_px) {
  const int side = 2 * radius_px + 1;
  std::vector<int> above(static_cast<std::size_t>(mask.width()), 0);  // Pixels inside in a row that end here, upward.
  std::int64_t count = 0;
  for (int y = 0; y < mask.height(); ++y) {
    int beside = 0;  // Columns in a row that are inside over a window's height.
    for (int x = 0; x < mask.width(); ++x) {
      int& height = above[x];
      height = mask.at(x, y) != 0 ? height + 1 : 0;
      beside = height >= side ? beside + 1 : 0;
      count += beside >= side ? 1 : 0;
    }
  }
  return count;
}

}  // namespace patinate::transfer
