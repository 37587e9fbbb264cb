#include "simulation/job/outcome_json.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/text.h"

namespace patinate::simulation {

Json outcome_json(const std::vector<ObjectOutcome>& outcome) {
  const auto number = [](double value) { return rounded(value, 4); };
  Json objects = Json::object();
  for (const ObjectOutcome& o : outcome) {
    Json materials = Json::object();
    for (const MaterialOutcome& m : o.materials) {
      materials[m.material] = {{"mean", number(m.mean)},
                               {"largest", number(m.largest)},
                               {"shows_share", number(m.shows_share)},
                               {"hides_share", number(m.hides_share)},
                               {"full_share", number(m.full_share)}};
    }
    Json& entry = objects[o.object];
    entry = {{"change_mean", number(o.change_mean)}, {"change_p95", number(o.change_p95)}};
    if (o.never_met_share) entry["never_met_share"] = number(*o.never_met_share);
    entry["materials"] = std::move(materials);
  }
  return {{"objects", objects}, {"advice", outcome_advice(outcome)}};
}

}  // namespace patinate::simulation
