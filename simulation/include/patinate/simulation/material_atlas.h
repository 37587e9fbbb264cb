/// \file
/// Amounts of up to 8 materials at every texel, as integers in pages.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// An amount is a density per surface area: 1 = kAmountOne quanta, up to 65535 (just under 4). Mass = amount quanta *
/// area weight.
inline constexpr std::uint32_t kAmountOne = 16384;
inline constexpr std::uint32_t kMaxAmount = 65535;

/// Amounts by material: plane after plane, each in pages of 64 x 64 texels (TileGrid's order, 8 KB) that are made when
/// first written. A page that is not there holds the original amounts, which are one value for each object and
/// material. Different pages may be made and written by several threads at once.
class MaterialAtlas {
 public:
  /// @param originals  Amount quanta by object, then material; at most kMaxAmount.
  /// @param surface    Outlives the atlas.
  MaterialAtlas(const SurfaceAtlas& surface, int num_materials,
                std::vector<std::array<std::uint16_t, kMaxMaterials>> originals);
  ~MaterialAtlas();
  MaterialAtlas(MaterialAtlas&&) noexcept;
  MaterialAtlas& operator=(MaterialAtlas&&) noexcept;

  [[nodiscard]] const SurfaceAtlas& surface() const { return *surface_; }
  [[nodiscard]] int num_materials() const { return num_materials_; }

  [[nodiscard]] std::uint16_t original(int material, TexelIndex t) const;
  [[nodiscard]] std::uint16_t amount(int material, TexelIndex t) const;
  /// The 64 amounts of a tile; empty when its page is not there.
  [[nodiscard]] std::span<const std::uint16_t> tile(int material, TileIndex tile) const;
  /// The same, made when missing.
  [[nodiscard]] std::span<std::uint16_t> writable_tile(int material, TileIndex tile);
  /// The 64 amounts of a tile as they are, whether its page is there or not.
  void read_tile(int material, TileIndex tile, std::span<std::uint16_t, TileGrid::kTileTexels> out) const;
  /// The 4096 amounts of a page (TileGrid::page_of); empty when it is not there.
  [[nodiscard]] std::span<const std::uint16_t> page(int material, std::uint32_t index) const;

  /// Sum over texels of amount * area weight. In parallel, exact.
  [[nodiscard]] std::int64_t mass(int material, const RunControl& control = {}) const;
  /// Hash over all amounts (whether stored or implied), in texel order: equal for equal states.
  [[nodiscard]] std::string hash() const;
  /// Bytes of all pages.
  [[nodiscard]] std::size_t memory() const;

 private:
  struct Pages;
  const SurfaceAtlas* surface_;
  int num_materials_;
  std::vector<std::array<std::uint16_t, kMaxMaterials>> originals_;
  std::unique_ptr<Pages> pages_;
};

}  // namespace patinate::simulation
