/// \file
/// The mass ledger as every file and every message of ours has it.
#pragma once

#include <span>
#include <string>

#include "patinate/core/json.h"
#include "patinate/simulation/ledger.h"

namespace patinate::simulation {

/// {MATERIAL: {"emitted", "made", "on_surfaces", "carried", "absorbed", "rested", "left", "used", "residual"}}, in
/// amounts on texels of median size; residual = MassAccount::imbalance(), exactly 0 in a run that lost nothing.
[[nodiscard]] Json ledger_json(const MassLedger& ledger, std::span<const std::string> materials);

}  // namespace patinate::simulation
