#include "simulation/job/outcome_json.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"

namespace patinate::simulation {

namespace {

constexpr double kMaxShare = 1.0001;  ///< Areas are sums of floats.

/// Of four digits; files of earlier versions may lack it.
void describe_number(DocumentVisitor& v, std::string_view name, std::string_view help, double& value,
                     Range range = {}) {
  value = rounded(value, 4);
  v.member({name, help, range, Presence::Optional}, value);
}

}  // namespace

void describe(DocumentVisitor& v, MaterialOutcome& m) {
  const Range shares = between(0, kMaxShare);
  describe_number(v, "mean", "Amount; 1 = a full layer.", m.mean);
  describe_number(v, "largest", "Amount.", m.largest);
  describe_number(v, "shows_share", "Where what has come covers a tenth of the color or more.", m.shows_share, shares);
  describe_number(v, "hides_share", "Where it covers all of it.", m.hides_share, shares);
  describe_number(v, "full_share", "Where a texel holds no more (amount 4).", m.full_share, shares);
}

void describe(DocumentVisitor& v, ObjectOutcome& o) {
  describe_number(v, "change_mean", "Delta E 1976 from the first frame.", o.change_mean);
  describe_number(v, "change_p95", "Its 95th percentile over texels.", o.change_p95);
  if (o.never_met_share) o.never_met_share = rounded(*o.never_met_share, 4);
  v.member(
      if_set("never_met_share",
             "Where no gammaton ever was, as wide as it is; absent where a run went on from a snapshot of an older "
             "version, which does not tell.",
             between(0, kMaxShare)),
      o.never_met_share);
  Named<MaterialOutcome> materials;
  for (const MaterialOutcome& m : o.materials) materials.emplace_back(m.material, m);
  v.member({.name = "materials", .presence = Presence::Optional}, materials);
}

void describe_outcome(DocumentVisitor& v, const std::vector<ObjectOutcome>& outcome) {
  Named<ObjectOutcome> objects;
  for (const ObjectOutcome& o : outcome) objects.emplace_back(o.object, o);
  std::vector<std::string> advice = outcome_advice(outcome);
  v.member({.name = "objects", .help = "By name.", .presence = Presence::Optional}, objects);
  v.member({.name = "advice", .help = "What is likely wrong, and what helps.", .presence = Presence::Optional}, advice);
}

Json outcome_json(const std::vector<ObjectOutcome>& outcome) {
  return object_json([&](DocumentVisitor& v) { describe_outcome(v, outcome); });
}

}  // namespace patinate::simulation
