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
#include "simulation/transport/splat_kernel.h"
#include "simulation/transport/splat_planes.h"

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
  transport::SplatKernel kernel;
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
  static constexpr std::size_t kMaxLanes = SplatShape::kMaxParts;
  static_assert(kMaxLanes % transport::kLaneBlock == 0);
  static constexpr std::size_t kFewParts = 13;
  struct Part {
    TexelIndex texel;
    std::uint32_t weight, share;
  };
  using Plane = std::array<std::uint16_t, kMaxLanes + SplatPlace::kSlack>;
  ShareTable table;
  std::vector<std::uint16_t*> pages;   ///< Of the region, by page and active material; null: the originals.
  std::vector<std::uint8_t> is_known;  ///< By page of the region: whether `pages` has it.
  std::array<Part, kFewParts> parts;   ///< Of a splat of few texels,
  std::array<std::array<std::uint32_t, kFewParts>, kMaxMaterials> mass;               ///< by active material and part.
  alignas(64) Plane weight, amount, left, any;                                        ///< By lane of a splat.
  alignas(64) std::array<std::array<std::int32_t, kMaxLanes>, kMaxMaterials> quanta;  ///< By active material and lane.
  std::array<std::uint32_t, kMaxLanes> number, before, after;                         ///< By lane, where areas differ,
  std::vector<double> shares;                                                         ///< and ShareTable::even().
  /// By active material: a page of original amounts, all of one value.
  std::array<std::vector<std::uint16_t>, kMaxMaterials> originals;
  std::array<std::int64_t, kMaxMaterials> dropped{};
  std::array<std::int64_t, kMaxMaterials> picked_up{};
};

/// Contacts and pieces of a region exchange in the order of their gammatons. Different regions may be worked on at
/// once.
void exchange_region(const RegionCall& call, std::uint32_t region, RegionWorker& worker);

}  // namespace patinate::simulation
