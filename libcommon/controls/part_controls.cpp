#include "libcommon/controls/part_controls.h"

#include <algorithm>
#include <limits>

#include "libcommon/controls/control_arguments.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// value(t) of the covered texels of a part.
template <class Value>
ImageF values_of(const TexelMap& map, const TexelRect& part, const RunControl& control, const Value& value) {
  ImageF values(part.width(), part.height());
  parallel_for(part.height(), 16, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < part.width(); ++x) {
        const TexelId t = TexelId{part.y0 + y} * map.width() + part.x0 + x;
        if (map.is_covered(t)) values.at(x, y) = value(t);
      }
    }
  });
  return values;
}

}  // namespace

ControlMap facing_part(const TexelMap& map, const FacingOptions& options, const TexelRect& part,
                       const RunControl& control) {
  check_ranges(options);
  const Vec3 direction = unit_direction(options.direction, "direction");
  return {values_of(map, part, control,
                    [&](TexelId t) { return static_cast<float>(std::clamp(map.normal(t).dot(direction), 0.0, 1.0)); }),
          0.0,
          1.0,
          "cosine",
          {}};
}

ControlMap height_part(const TexelMap& map, const std::array<double, 3>& up_numbers, const TexelRect& part,
                       const RunControl& control) {
  const Vec3 up = unit_direction(up_numbers, "up");
  const Mesh& mesh = map.mesh();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Triangle& t : mesh.triangles) {
    for (const int corner : t) {
      const double height = mesh.positions[corner].dot(up);
      low = std::min(low, height);
      high = std::max(high, height);
    }
  }
  const double range = high > low ? high - low : 1.0;
  return {values_of(map, part, control,
                    [&](TexelId t) {
                      const double height = static_cast<double>(static_cast<float>(map.position_mm(t).dot(up) - low));
                      return static_cast<float>(std::clamp(height / range, 0.0, 1.0));
                    }),
          0.0,
          range,
          "mm",
          {}};
}

void require_part_control(const std::string& expression) {
  const ControlExpression parsed(expression, control_kind_names());
  for (const ControlName& name : parsed.names()) {
    if (!name.is_file && (name.text == "facing" || name.text == "height")) continue;
    throw ParseError("`" + name.text + "` " + (name.is_file ? "is a file" : "looks at the whole atlas") +
                     ", which no process holds by tile; use facing, height and expressions of them");
  }
}

ControlMap make_part_control(const std::string& expression, const TexelMap& map, const TexelRect& part,
                             const ControlKindOptions& options, const RunControl& control) {
  require_part_control(expression);
  const ControlExpression parsed(expression, control_kind_names());
  ImageU8 coverage(part.width(), part.height());
  for (int y = 0; y < part.height(); ++y) {
    for (int x = 0; x < part.width(); ++x) {
      if (map.is_covered(TexelId{part.y0 + y} * map.width() + part.x0 + x)) coverage.at(x, y) = 255;
    }
  }
  return parsed.evaluate(coverage, [&](const ControlName& name) -> ControlMap {
    const ControlKindOptions named = named_options(name, options);
    return name.text == "facing" ? facing_part(map, named.facing, part, control)
                                 : height_part(map, named.up, part, control);
  });
}

}  // namespace patinate
