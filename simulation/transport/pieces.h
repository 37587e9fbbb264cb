/// \file
/// What gammatons wider than a texel are cut into: pieces that exchange on their own and are summed again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "simulation/transport/cargo.h"
#include "simulation/transport/contact_sort.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/trail.h"

namespace patinate::simulation {

/// By material.
using Masses = std::array<std::uint32_t, kMaxMaterials>;

/// A part of a gammaton's splat. What it has of the cargo stands beside it: Pieces::mass().
struct Piece {
  std::uint32_t contact = 0;
  std::uint16_t number = 0;  ///< In its splat; 0 = middle.
  std::uint32_t share = SplatShape::kWhole;
};

/// Another random number of one: uniform where it is, and without a visible relation to it.
[[nodiscard]] inline std::uint32_t mixed(std::uint32_t random, std::uint32_t purpose) {
  std::uint32_t x = random + purpose * 0x9E3779B9u;
  x = (x ^ x >> 16) * 0x7FEB352Du;
  x = (x ^ x >> 15) * 0x846CA68Bu;
  return x ^ x >> 16;
}

/// What is cut.
struct WideContacts {
  const SurfaceAtlas& surface;
  std::span<const Contact> contacts;
  std::span<const Ending> endings;  ///< Of a deposit: by contact, which is at the end. Else empty.
  std::span<const int> active;      ///< Materials.
  std::uint64_t seed;
  std::int64_t random_key;
};

/// Keeps its memory from call to call.
class Pieces {
 public:
  /// @param width  Of a splat, in texels of median size.
  /// @param keys   Is filled: the carrier is a piece's number among all.
  void cut(const WideContacts& of, double width, const Cargo& cargo, std::vector<ContactKey>& keys,
           const RunControl& control);
  /// Sums the pieces' cargo up again.
  void join(const WideContacts& of, Cargo& cargo, const RunControl& control) const;

  /// By the keys' carrier.
  [[nodiscard]] std::span<const Piece> pieces() const { return pieces_; }
  /// What pieces carry, by carrier and active material.
  [[nodiscard]] std::span<std::uint32_t> mass() { return mass_; }
  /// By contact and active material.
  [[nodiscard]] std::span<const Masses> randoms() const { return randoms_; }

 private:
  void append_parts(const WideContacts& of, std::size_t begin, std::size_t end, std::vector<SplatPart>& parts);

  std::array<std::optional<SplatShape>, Trail::kLength + 1> shapes_;  ///< By the length of the trail; 0 = a contact.
  std::vector<std::vector<SplatPart>> parts_;                         ///< By chunk of contacts.
  std::vector<std::uint32_t> first_piece_;                            ///< By contact, and the end.
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> mass_;
  std::vector<Masses> randoms_;
};

}  // namespace patinate::simulation
