#include "app/request/unit_argument.h"

#include <optional>

#include "app/request/usage_error.h"
#include "libcommon/geometry/length_unit.h"

namespace patinate::app {

double mm_per_unit(const std::string& unit) {
  const std::optional<double> mm = find_mm_per_unit(unit);
  if (!mm) throw UsageError("--unit: found `" + unit + "`; expected one of um, mm, cm, m");
  return *mm;
}

}  // namespace patinate::app
