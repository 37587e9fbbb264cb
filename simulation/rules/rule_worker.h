/// \file
/// What a thread works with while rules act. For rules.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "simulation/rules/layer_cracking.h"
#include "simulation/rules/layer_tile.h"
#include "simulation/rules/rule_kernel.h"

namespace patinate::simulation {

struct alignas(64) BlockOf64 {
  std::array<float, TileGrid::kTileTexels> values;
};

/// Data of one thread; which thread it is shows in no result.
struct RuleWorker {
  std::vector<BlockOf64> slots;                      ///< As CompiledRules has them, then the programs' own.
  std::vector<std::array<std::int32_t, 64>> quanta;  ///< By material, then by state of layers.
  std::array<std::array<std::int32_t, 64>, kMaxRuleTerms> changes{};
  std::array<std::int64_t, kMaxMaterials> made{};
  std::array<std::int64_t, kMaxMaterials> used{};
  std::optional<LayerTile> layers;  ///< Where there are any.
  LayerSums sums;
  std::vector<TileIndex> opened;  ///< Tiles where another layer shows now.
  LayerCracking::Finds cracking;
};

}  // namespace patinate::simulation
