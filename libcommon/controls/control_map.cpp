#include "patinate/controls/control_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

ValueRange area_percentiles(const ImageF& values, const TexelMap& map, double low_percent, double high_percent) {
  struct Entry {
    float value;
    float area;
  };
  std::vector<Entry> entries;
  entries.reserve(map.num_covered());
  double total = 0.0, area = 0.0;
  int area_triangle = -1;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const int triangle = map.point(t).triangle;
    if (triangle != area_triangle) {
      const Eigen::Matrix<double, 3, 2> step = map.mm_per_texel(triangle);
      area = step.col(0).cross(step.col(1)).norm();
      area_triangle = triangle;
    }
    entries.push_back({values.values()[t], static_cast<float>(area)});
    total += static_cast<double>(entries.back().area);
  }
  if (entries.empty()) throw InvalidInput("the atlas covers no texel; are the UVs of the mesh all in one point?");
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.value != b.value ? a.value < b.value : a.area < b.area; });
  const auto value_at = [&](double percent) {
    double below = 0.0;
    for (const Entry& e : entries) {
      below += static_cast<double>(e.area);
      if (below >= percent / 100.0 * total) return static_cast<double>(e.value);
    }
    return static_cast<double>(entries.back().value);
  };
  return {value_at(low_percent), value_at(high_percent)};
}

Vec3 unit_direction(const std::array<double, 3>& numbers, const std::string& option) {
  const Vec3 direction(numbers[0], numbers[1], numbers[2]);
  const double length = direction.norm();
  if (!(length > 0.0 && std::isfinite(length))) {
    throw InvalidInput(option + ": needs a finite length > 0; use for example 0,1,0");
  }
  return direction / length;
}

ControlMap normalized_control(const ImageF& values, const TexelMap& map, const ValueRange& range, std::string unit) {
  if (!(range.high > range.low)) {
    throw InvalidInput("control map: its range [" + number_text(range.low) + ", " + number_text(range.high) +
                       "] is empty");
  }
  ControlMap out{ImageF(map.width(), map.height()), range.low, range.high, std::move(unit), {}};
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const auto i = static_cast<std::size_t>(t);
    const double v = (static_cast<double>(values.values()[i]) - range.low) / (range.high - range.low);
    out.values.values()[i] = static_cast<float>(std::clamp(v, 0.0, 1.0));
  }
  return out;
}

void note_if_even(ControlMap& control, const ImageU8& coverage, const std::string& name) {
  constexpr float kEven = 1e-3F;
  float least = 2.0F, greatest = -1.0F;
  for (std::size_t i = 0; i < coverage.values().size(); ++i) {
    if (coverage.values()[i] == 0) continue;
    least = std::min(least, control.values.values()[i]);
    greatest = std::max(greatest, control.values.values()[i]);
  }
  if (!(greatest >= least) || greatest - least > kEven) return;
  const double value = rounded(static_cast<double>(least), 3);
  control.notes.push_back("control `" + name + "` is " + short_number_text(value) +
                          " on the whole surface; a map that is even guides nothing");
}

}  // namespace patinate
