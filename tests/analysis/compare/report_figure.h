/// \file
/// One figure of a report.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate::testing_support {

[[nodiscard]] inline const Json& report_figure(const Json& report, const std::string& name) {
  for (const Json& f : report.at("figures")) {
    if (f.at("name") == name) return f;
  }
  throw InvalidInput("no figure " + name);
}

}  // namespace patinate::testing_support
