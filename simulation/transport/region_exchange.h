/// \file
/// The contacts of one region, one after the other: what Exchanger's threads do.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "simulation/transport/parameter_maps.h"
#include "simulation/transport/pieces.h"
#include "simulation/transport/regions.h"
#include "simulation/transport/share_table.h"

namespace patinate::simulation {

/// What all contacts of a call share.
struct RegionCall {
  std::uint64_t seed;
  std::int64_t iteration, random_key;
  std::span<const int> active;
  Cargo& cargo;
  MaterialAtlas& atlas;
  const Regions& regions;
  ParameterMaps* maps;  ///< May be null.
  bool is_deposit;
  bool is_wide;  ///< Contacts have splats.
  std::span<const Contact> contacts;
  std::span<const std::uint16_t> sizes;   ///< By contact: SplatShape::size_at().
  const RegionLists& contact_lists;       ///< Of those that lie in one region, away from seams.
  std::span<const Contact> cut_contacts;  ///< The others,
  std::span<const Piece> pieces;          ///< and what they are cut into.
  std::span<std::uint32_t> piece_mass;
  std::span<const Masses> piece_randoms;
  const RegionLists& piece_lists;
  std::span<std::uint64_t> dirty_pages;  ///< By page: a bit for each tile whose amounts changed is set.
};

/// What one thread needs; which thread it is shows in no result.
struct RegionWorker {
  struct Part {
    TexelIndex texel;
    std::uint32_t weight, share;
  };
  ShareTable table;
  std::vector<std::uint16_t*> pages;   ///< Of the region, by page and active material; null: the originals.
  std::vector<std::uint8_t> is_known;  ///< By page of the region: whether `pages` has it.
  std::array<Part, SplatShape::kMaxParts> parts;
  std::array<std::array<std::uint32_t, SplatShape::kMaxParts>, kMaxMaterials> mass;  ///< By active material and part.
  std::array<std::int64_t, kMaxMaterials> dropped{};
  std::array<std::int64_t, kMaxMaterials> picked_up{};
};

/// Contacts and pieces of a region exchange in the order of their gammatons. Different regions may be worked on at
/// once.
void exchange_region(const RegionCall& call, std::uint32_t region, RegionWorker& worker);

}  // namespace patinate::simulation
