#include "tools/patinate/command_line/unit_argument.h"

#include <optional>

#include "libcommon/geometry/length_unit.h"
#include "tools/patinate/command_line/usage_error.h"

namespace patinate::cli {

double mm_per_unit(const std::string& unit) {
  const std::optional<double> mm = find_mm_per_unit(unit);
  if (!mm) throw UsageError("--unit: found `" + unit + "`; expected one of um, mm, cm, m");
  return *mm;
}

}  // namespace patinate::cli
