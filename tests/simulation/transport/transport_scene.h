/// \file
/// Small surfaces with texels of unequal area, and contacts on them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "patinate/simulation/material_atlas.h"
#include "simulation/transport/cargo.h"

namespace patinate::testing_support {

/// A surface and its amounts.
struct TransportScene {
  std::unique_ptr<simulation::SurfaceAtlas> surface;
  std::unique_ptr<simulation::MaterialAtlas> atlas;
  std::vector<simulation::TexelIndex> covered;
};

/// A plane whose UVs are squeezed toward one side: weights from about 100 to 4000. Three materials with 0, 1 and 0.5 of
/// each at first.
[[nodiscard]] TransportScene squeezed_plane(int resolution);
/// cut_plane(): a seam, texels of one size.
[[nodiscard]] TransportScene seamed_plane(int resolution);

/// `n` contacts of gammatons 0 to n - 1 with texels of which one in `crowding` is used.
[[nodiscard]] std::vector<simulation::Contact> random_contacts(const TransportScene& scene, std::uint32_t n,
                                                               std::uint64_t seed, std::uint32_t crowding = 1);
/// Gammatons with up to `most` of each of three materials, in any quanta.
[[nodiscard]] simulation::Cargo random_cargo(std::uint32_t n, double most, std::uint64_t seed);
/// Mass of a material that all of them carry.
[[nodiscard]] std::int64_t cargo_mass(const simulation::Cargo& cargo, std::size_t material);

}  // namespace patinate::testing_support
