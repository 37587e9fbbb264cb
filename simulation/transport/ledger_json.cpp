#include "simulation/transport/ledger_json.h"

#include <nlohmann/json.hpp>

namespace patinate::simulation {

void describe(DocumentVisitor& v, LedgerRow& row) {
  for (const auto& [name, value] : {std::pair("emitted", &row.emitted),
                                    {"made", &row.made},
                                    {"on_surfaces", &row.on_surfaces},
                                    {"carried", &row.carried},
                                    {"absorbed", &row.absorbed},
                                    {"rested", &row.rested},
                                    {"left", &row.left},
                                    {"used", &row.used}})
    v.member({.name = name, .help = "Amounts on texels of median size.", .presence = Presence::Optional}, *value);
  v.member({.name = "residual",
            .help = "What does not balance: 0. Earlier versions did not write it.",
            .presence = Presence::Optional},
           row.residual);
}

Named<LedgerRow> ledger_rows(const MassLedger& ledger, std::span<const std::string> materials) {
  constexpr double kUnit = 1.0 / (double{kAmountOne} * SurfaceAtlas::kMedianWeight);
  Named<LedgerRow> rows;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const MassAccount& a = ledger.account(static_cast<int>(m));
    const auto amount = [](const auto& mass) { return mass.value() * kUnit; };
    rows.emplace_back(materials[m], LedgerRow{amount(a.emitted), amount(a.made), amount(a.on_surfaces),
                                              amount(a.carried), amount(a.absorbed), amount(a.rested), amount(a.left),
                                              amount(a.used), amount(a.imbalance())});
  }
  return rows;
}

Json ledger_json(const MassLedger& ledger, std::span<const std::string> materials) {
  Named<LedgerRow> rows = ledger_rows(ledger, materials);
  return object_json([&](DocumentVisitor& v) { v.member({"ledger"}, rows); })["ledger"];
}

}  // namespace patinate::simulation
