/// \file
/// transfer_shares() of the weights and shares that turn up: a few hundred of them serve a million contacts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "simulation/transport/splat.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

/// Of one thread; what it holds shows in no result.
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
        found[a] = transfer_shares(options_.ratio, options_.rates[static_cast<std::size_t>(active_[a])],
                                   options_.contact, weight, area_ * share / SplatShape::kWhole);
      }
    }
    return found;
  }

 private:
  static constexpr int kSizeBits = 12;
  static constexpr std::size_t kSize = std::size_t{1} << kSizeBits;
  ExchangeOptions options_;
  double area_ = 1.0;
  std::vector<int> active_;
  std::vector<std::uint64_t> keys_;
  std::vector<TransferShares> shares_;
};

}  // namespace patinate::simulation
