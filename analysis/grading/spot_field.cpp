#include "analysis/grading/spot_field.h"

#include <utility>

namespace patinate::analysis {

SpotField spot_field(const std::vector<char>& is_inside, int width, int height) {
  SpotField field{std::vector<int>(is_inside.size(), -1), std::vector<int>(is_inside.size(), kFarFromSpots), {}};
  const auto each_neighbor = [&](std::size_t i, const auto& visit) {
    const int x = static_cast<int>(i % width), y = static_cast<int>(i / width);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if ((dx != 0 || dy != 0) && x + dx >= 0 && y + dy >= 0 && x + dx < width && y + dy < height)
          visit(i + static_cast<std::size_t>(dy * width + dx));
      }
    }
  };
  std::vector<std::size_t> front;
  for (std::size_t first = 0; first < is_inside.size(); ++first) {
    if (!is_inside[first] || field.labels[first] >= 0) continue;
    const int label = static_cast<int>(field.pixels.size());
    std::vector<std::size_t>& own = field.pixels.emplace_back();
    field.labels[first] = label;
    own.push_back(first);
    for (std::size_t k = 0; k < own.size(); ++k) {
      each_neighbor(own[k], [&](std::size_t j) {
        if (!is_inside[j] || field.labels[j] >= 0) return;
        field.labels[j] = label;
        own.push_back(j);
      });
    }
  }
  for (const std::vector<std::size_t>& own : field.pixels) {
    for (const std::size_t i : own) {
      bool is_edge = false;
      each_neighbor(i, [&](std::size_t j) { is_edge = is_edge || !is_inside[j]; });
      field.steps[i] = is_edge ? 0 : -kFarRing_px;
      if (is_edge) front.push_back(i);
    }
  }
  // Inward, then outward.
  std::vector<std::size_t> edge = front;
  for (int step = -1; step > -kFarRing_px; --step) {
    std::vector<std::size_t> next;
    for (const std::size_t i : front) {
      each_neighbor(i, [&](std::size_t j) {
        if (!is_inside[j] || field.steps[j] != -kFarRing_px) return;
        field.steps[j] = step;
        next.push_back(j);
      });
    }
    front = std::move(next);
  }
  front = std::move(edge);
  for (int step = 1; step <= kFarRing_px; ++step) {
    std::vector<std::size_t> next;
    for (const std::size_t i : front) {
      each_neighbor(i, [&](std::size_t j) {
        if (field.labels[j] >= 0) return;
        field.labels[j] = field.labels[i];
        field.steps[j] = step;
        field.pixels[static_cast<std::size_t>(field.labels[i])].push_back(j);
        next.push_back(j);
      });
    }
    front = std::move(next);
  }
  return field;
}

}  // namespace patinate::analysis
