/// \file
/// Where all mass of a run is, in integers that must balance exactly.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "patinate/simulation/material_atlas.h"

namespace patinate::simulation {

struct Cargo;
struct ExchangeReport;

/// A sum of mass quanta that does not overflow: high * 2^32 + low. A million gammatons with 16 of everything, born
/// again in each of a million iterations, are 2^66.
class MassSum {
 public:
  MassSum& operator+=(std::int64_t quanta);
  MassSum& operator+=(const MassSum& other);
  MassSum& operator-=(const MassSum& other);
  friend bool operator==(const MassSum&, const MassSum&) = default;
  /// Rounded; exact below 2^53.
  [[nodiscard]] double value() const;
  [[nodiscard]] std::int64_t high() const { return high_; }
  [[nodiscard]] std::uint32_t low() const { return low_; }
  [[nodiscard]] static MassSum from_parts(std::int64_t high, std::uint32_t low);

 private:
  std::int64_t high_ = 0;
  std::uint32_t low_ = 0;
};

enum class CargoEnd {
  Left,
  Absorbed,
  Rested
};  ///< How a gammaton's life ends: outside the scene, in a surface, still on the ground.

/// Mass by what became of it, for one material. Balance: emitted + made = on_surfaces + carried + left + absorbed +
/// rested + used.
struct MassAccount {
  MassSum emitted;      ///< Loaded at births.
  MassSum on_surfaces;  ///< Change since the start, may be below 0.
  MassSum carried;      ///< Under way.
  MassSum left;         ///< Mass carried away by gammatons that left the scene,
  MassSum absorbed;     ///< that were absorbed,
  MassSum rested;       ///< that came to rest.
  MassSum made;         ///< By rules.
  MassSum used;         ///< By rules.
  /// (emitted + made) - all others: 0 in a run that lost nothing.
  [[nodiscard]] MassSum imbalance() const;
};

/// The accounts of all materials. A plain value: a run that is resumed continues with a copy.
class MassLedger {
 public:
  /// Mass quanta that a gammaton has at birth: round(amount * area * kAmountOne * kMedianWeight), at most 2^32 - 1.
  /// @param area  That the amounts cover, in texels of median size; > 0.
  [[nodiscard]] static std::array<std::uint32_t, kMaxMaterials> cargo_of(const MaterialValues& carries,
                                                                         double area = 1.0);

  /// Loads a gammaton, which must be empty.
  void birth(std::uint32_t gammaton, const std::array<std::uint32_t, kMaxMaterials>& load, Cargo& cargo);
  /// Empties it.
  void end(std::uint32_t gammaton, CargoEnd how, Cargo& cargo);
  void add(const ExchangeReport& report);
  /// What rules changed on the surface.
  void add_rules(const std::array<std::int64_t, kMaxMaterials>& made,
                 const std::array<std::int64_t, kMaxMaterials>& used);

  [[nodiscard]] const MassAccount& account(int material) const { return accounts_[material]; }
  [[nodiscard]] MassAccount& account(int material) { return accounts_[material]; }
  [[nodiscard]] bool balances() const;

 private:
  std::array<MassAccount, kMaxMaterials> accounts_;
};

/// Compares the mass balance with what is there: sums all texels and all cargo (slow). @returns what is wrong, "" if
/// nothing.
/// @param at_interfaces  Mass of each material below layers, which is on the surfaces too; may be empty.
[[nodiscard]] std::string audit(const MassLedger& ledger, const MaterialAtlas& atlas, const Cargo& cargo,
                                std::span<const std::string> materials, const RunControl& control = {},
                                std::span<const std::int64_t> at_interfaces = {});

}  // namespace patinate::simulation
