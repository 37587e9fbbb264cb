/// \file
/// The contacts of one region, one after the other: what Exchanger's threads do.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "simulation/transport/parameter_maps.h"
#include "simulation/transport/pieces.h"
#include "simulation/transport/regions.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/splat_kernel.h"
#include "simulation/transport/splat_planes.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

/// Table of one thread; its content shows in no result.
class ShareTable {
 public:
  /// @param area  Of a contact, in texels of median size.
  void reset(const ExchangeOptions& options, double area, std::span<const int> active) {
    const bool is_same = !keys_.empty() && options.ratio == options_.ratio && options.contact == options_.contact &&
                         options.rates == options_.rates && area == area_;
    if (is_same && std::equal(active.begin(), active.end(), active_.begin(), active_.end())) return;
    options_ = options;
    area_ = area;
    active_.assign(active.begin(), active.end());
    keys_.assign(kSize, 0);
    shares_.resize(kSize * active.size());
    even_.assign(kEvenSize, {});
  }
  /// By active material.
  [[nodiscard]] const TransferShares* find(std::uint32_t weight, std::uint32_t share) {
    const std::uint64_t key = std::uint64_t{weight} << 32 | share;
    // Shares are often multiples of 2^12.
    const std::size_t slot = (weight * 0x85EBCA6Bu + share * 0x9E3779B1u) >> (32 - kSizeBits);
    TransferShares* found = shares_.data() + slot * active_.size();
    if (keys_[slot] != key) {
      keys_[slot] = key;
      for (std::size_t a = 0; a < active_.size(); ++a) {
        found[a] = transfer_shares(options_.ratio, options_.rates[active_[a]], options_.contact, weight,
                                   area_ * share / SplatShape::kWhole);
      }
    }
    return found;
  }
  /// Factors of a stencil's lanes where all texels have one weight: by active material, `up` of all lanes, then `down`.
  /// @param size  Of the stencil. Good until the next call.
  [[nodiscard]] const double* even(const SplatStencil& stencil, int size, std::uint32_t weight) {
    const std::uint32_t key = static_cast<std::uint32_t>(size) << 16 | weight;
    EvenShares& found = even_[key * 0x9E3779B1u >> (32 - kEvenBits)];
    if (found.key == key) return found.values.data();
    found.key = key;
    const auto num = static_cast<std::size_t>(stencil.num_lanes);
    found.values.assign(2 * num * active_.size(), 0.0);
    for (std::size_t k = 0; k < stencil.parts.size(); ++k)
      put(find(weight, stencil.parts[k].share), num, stencil.lane_of[k], found.values.data());
    return found.values.data();
  }
  /// Writes the shares of one of `num` lanes to `out`, in the layout of even().
  void put(const TransferShares* shares, std::size_t num, std::size_t lane, double* out) const {
    for (std::size_t a = 0; a < active_.size(); ++a) {
      out[2 * a * num + lane] = shares[a].up;
      out[(2 * a + 1) * num + lane] = shares[a].down;
    }
  }

 private:
  struct EvenShares {
    std::uint32_t key = 0;  ///< No stencil's: sizes and weights are 1 or more.
    std::vector<double> values;
  };
  static constexpr int kSizeBits = 12;
  static constexpr std::size_t kSize = std::size_t{1} << kSizeBits;
  static constexpr int kEvenBits = 5;
  static constexpr std::size_t kEvenSize = std::size_t{1} << kEvenBits;
  ExchangeOptions options_;
  double area_ = 1.0;
  std::vector<int> active_;
  std::vector<std::uint64_t> keys_;
  std::vector<TransferShares> shares_;
  std::vector<EvenShares> even_;
};

/// Data that all contacts of a call share.
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
  const RegionLists& contact_lists;       ///< Contact lists of those that lie in one region, away from seams.
  std::span<const Contact> cut_contacts;  ///< The others,
  std::span<const Piece> pieces;          ///< and what they are cut into.
  std::span<std::uint32_t> piece_mass;
  std::span<const Masses> piece_randoms;
  const RegionLists& piece_lists;
  std::span<std::uint64_t> dirty_pages;  ///< By page: a bit for each tile whose amounts changed is set.
};

/// Data that one thread needs; which thread it is shows in no result.
struct RegionWorker {
  static constexpr std::size_t kMaxLanes = SplatShape::kMaxParts;
  static_assert(kMaxLanes % transport::kLaneBlock == 0);
  /// Larger splats go to the vector kernel (docs/algorithms/material_exchange.md).
  static constexpr std::size_t kFewParts = 13;
  struct Part {
    TexelIndex texel;
    std::uint32_t weight, share;
  };
  using Plane = std::array<std::uint16_t, kMaxLanes + SplatPlace::kSlack>;
  ShareTable table;
  std::vector<std::uint16_t*> pages;   ///< Pages of the region, by page and active material; null: the originals.
  std::vector<std::uint8_t> is_known;  ///< By page of the region: whether `pages` has it.
  std::array<Part, kFewParts> parts;   ///< Parts of a splat of few texels,
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
