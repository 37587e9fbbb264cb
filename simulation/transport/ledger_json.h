/// \file
/// The mass ledger as every file and every message of ours has it.
#pragma once

#include <span>
#include <string>

#include "libcommon/document/document.h"
#include "patinate/simulation/ledger.h"

namespace patinate::simulation {

/// A MassAccount in amounts on texels of median size; residual = MassAccount::imbalance(), exactly 0 in a run that lost
/// nothing.
struct LedgerRow {
  double emitted = 0.0, made = 0.0, on_surfaces = 0.0, carried = 0.0, absorbed = 0.0, rested = 0.0, left = 0.0,
         used = 0.0, residual = 0.0;
};
void describe(DocumentVisitor& v, LedgerRow& row);
/// By material.
[[nodiscard]] Named<LedgerRow> ledger_rows(const MassLedger& ledger, std::span<const std::string> materials);
/// The same as an object.
[[nodiscard]] Json ledger_json(const MassLedger& ledger, std::span<const std::string> materials);

}  // namespace patinate::simulation
