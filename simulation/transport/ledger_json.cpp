#include "simulation/transport/ledger_json.h"

#include <nlohmann/json.hpp>

namespace patinate::simulation {

Json ledger_json(const MassLedger& ledger, std::span<const std::string> materials) {
  constexpr double kUnit = 1.0 / (double{kAmountOne} * SurfaceAtlas::kMedianWeight);
  Json json = Json::object();
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const MassAccount& a = ledger.account(static_cast<int>(m));
    Json& row = json[materials[m]];
    row["emitted"] = a.emitted.value() * kUnit;
    row["made"] = a.made.value() * kUnit;
    row["on_surfaces"] = a.on_surfaces.value() * kUnit;
    row["carried"] = a.carried.value() * kUnit;
    row["absorbed"] = a.absorbed.value() * kUnit;
    row["rested"] = a.rested.value() * kUnit;
    row["left"] = a.left.value() * kUnit;
    row["used"] = a.used.value() * kUnit;
    row["residual"] = a.imbalance().value() * kUnit;
  }
  return json;
}

}  // namespace patinate::simulation
