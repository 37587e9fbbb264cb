#include "tools/patinate/study/design.h"

#include <utility>

namespace patinate::cli {

std::vector<std::vector<std::size_t>> grid_design(const std::vector<std::size_t>& num_levels) {
  std::vector<std::vector<std::size_t>> points{{}};
  for (const std::size_t count : num_levels) {
    std::vector<std::vector<std::size_t>> longer;
    for (const auto& point : points) {
      for (std::size_t level = 0; level < count; ++level) {
        longer.push_back(point);
        longer.back().push_back(level);
      }
    }
    points = std::move(longer);
  }
  return points;
}

}  // namespace patinate::cli
