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
#include "simulation/transport/regions.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/trail.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

/// By material.
using Masses = std::array<std::uint32_t, kMaxMaterials>;

/// A part of a gammaton's splat. What it has of the cargo stands beside it: Pieces::mass().
struct Piece {
  TexelIndex texel = 0;
  std::uint32_t contact = 0;  ///< Contact of WideContacts.
  std::uint16_t number = 0;   ///< In its splat; 0 = middle.
  std::uint32_t share = SplatShape::kWhole;
};

/// Contacts that are cut.
struct WideContacts {
  const SurfaceAtlas& surface;
  std::span<const Contact> contacts;
  std::span<const Ending> endings;  ///< Endings of a deposit: by contact, which is at the end. Else empty.
  std::span<const int> active;      ///< Materials.
  std::uint64_t seed;
  std::int64_t random_key;
};

/// Deals a gammaton's cargo out to the parts of its splat: whole quanta of its middle texel, as many to each as its
/// share says in the mean, and what is less than one to the middle. Amounts that are less than a quantum for every part
/// still find their way that way.
/// @param share_of  share_of(k): of part k, in 1/SplatShape::kWhole; of all together that is 1.
/// @param put       put(k, mass): what part k gets.
template <class Share, class Put>
void deal(std::uint32_t whole, std::uint32_t random, std::uint32_t middle_weight, std::size_t num_parts,
          Share&& share_of, Put&& put) {
  const std::uint64_t quanta = whole / middle_weight;
  const std::uint32_t start = transfer_kernel::deal_start(random);
  std::uint64_t share = 0, dealt = 0;
  for (std::size_t k = 0; k < num_parts; ++k) {
    share += share_of(k);
    const std::uint64_t until = transfer_kernel::dealt_to(quanta, share, start);
    put(k, static_cast<std::uint32_t>((until - dealt) * middle_weight) + (k == 0 ? whole % middle_weight : 0u));
    dealt = until;
  }
}

/// Random numbers of a gammaton where it ends; its contacts' are 0.
inline constexpr std::uint32_t kDepositPiece = 0x7FFFFFFEu;

/// Keeps its memory from call to call.
class Pieces {
 public:
  /// How a splat lies on the surface. @param width  In texels of median size.
  /// @param length  Of the trail that it ends; 0 = a contact.
  const SplatShape& shape_of(const SurfaceAtlas& surface, double width, std::size_t length);
  /// Lays splats and trails out, which parts() then has. @param width  Of a splat, in texels of median size.
  void lay(const WideContacts& of, double width, const RunControl& control);
  /// By chunk of contacts, one behind the other.
  [[nodiscard]] std::span<const std::vector<SplatPart>> parts() const { return parts_; }
  /// By contact, and the end: where its parts begin among all.
  [[nodiscard]] std::span<const std::uint32_t> first_parts() const { return first_piece_; }

  /// Cuts, and deals the cargo out. @param regions  Of the surface's grid.
  void cut(const WideContacts& of, double width, const Regions& regions, const Cargo& cargo, const RunControl& control);
  /// Sums the pieces' cargo up again.
  void join(const WideContacts& of, Cargo& cargo, const RunControl& control) const;

  /// Contact after contact.
  [[nodiscard]] std::span<const Piece> pieces() const { return pieces_; }
  /// The region that each is in.
  [[nodiscard]] std::span<const std::uint16_t> regions() const { return regions_; }
  /// Mass that pieces carry, by piece and active material.
  [[nodiscard]] std::span<std::uint32_t> mass() { return mass_; }
  /// By contact and active material.
  [[nodiscard]] std::span<const Masses> randoms() const { return randoms_; }

 private:
  void append_parts(const WideContacts& of, std::size_t begin, std::size_t end, std::vector<SplatPart>& parts);

  std::array<std::optional<SplatShape>, Trail::kLength + 1> shapes_;  ///< By the length of the trail; 0 = a contact.
  std::vector<std::vector<SplatPart>> parts_;                         ///< By chunk of contacts.
  std::vector<std::uint32_t> first_piece_;                            ///< By contact, and the end.
  std::vector<Piece> pieces_;
  std::vector<std::uint16_t> regions_;
  std::vector<std::uint32_t> mass_;
  std::vector<Masses> randoms_;
};

}  // namespace patinate::simulation
