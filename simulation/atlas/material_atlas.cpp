#include "patinate/simulation/material_atlas.h"

#include <algorithm>
#include <atomic>

#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"

namespace patinate::simulation {

struct MaterialAtlas::Pages {
  using Page = std::array<std::uint16_t, TileGrid::kPageTexels>;

  explicit Pages(std::size_t n) : pages(n) {}
  ~Pages() {
    for (std::atomic<Page*>& page : pages) delete page.load();
  }
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  std::vector<std::atomic<Page*>> pages;  // material-major
};

namespace {
[[nodiscard]] std::size_t page_slot(const TileGrid& grid, int material, std::uint32_t page) {
  return static_cast<std::size_t>(material) * grid.num_pages() + page;
}
}  // namespace

MaterialAtlas::MaterialAtlas(const SurfaceAtlas& surface, int num_materials,
                             std::vector<std::array<std::uint16_t, kMaxMaterials>> originals)
    : surface_(&surface),
      num_materials_(num_materials),
      originals_(std::move(originals)),
      pages_(std::make_unique<Pages>(static_cast<std::size_t>(num_materials) * surface.grid().num_pages())) {}

MaterialAtlas::~MaterialAtlas() = default;
MaterialAtlas::MaterialAtlas(MaterialAtlas&&) noexcept = default;
MaterialAtlas& MaterialAtlas::operator=(MaterialAtlas&&) noexcept = default;

std::uint16_t MaterialAtlas::original(int material, TexelIndex t) const {
  const int triangle = surface_->triangle(t);
  return triangle < 0 ? std::uint16_t{0} : originals_[surface_->object(triangle)][material];
}

std::uint16_t MaterialAtlas::amount(int material, TexelIndex t) const {
  const Pages::Page* page =
      pages_->pages[page_slot(surface_->grid(), material, TileGrid::page_of(t))].load(std::memory_order_acquire);
  return page ? (*page)[t % TileGrid::kPageTexels] : original(material, t);
}

std::span<const std::uint16_t> MaterialAtlas::tile(int material, TileIndex tile) const {
  const Pages::Page* page =
      pages_->pages[page_slot(surface_->grid(), material, tile / TileGrid::kPageTiles)].load(std::memory_order_acquire);
  if (!page) return {};
  return {page->data() + std::size_t{tile % TileGrid::kPageTiles} * TileGrid::kTileTexels, TileGrid::kTileTexels};
}

std::span<std::uint16_t> MaterialAtlas::writable_tile(int material, TileIndex tile) {
  const std::uint32_t index = tile / TileGrid::kPageTiles;
  std::atomic<Pages::Page*>& slot = pages_->pages[page_slot(surface_->grid(), material, index)];
  Pages::Page* page = slot.load(std::memory_order_acquire);
  if (!page) {  // whoever is first: all would make the same
    auto made = std::make_unique<Pages::Page>();
    for (std::uint32_t i = 0; i < TileGrid::kPageTexels; ++i)
      (*made)[i] = original(material, index * TileGrid::kPageTexels + i);
    if (slot.compare_exchange_strong(page, made.get(), std::memory_order_acq_rel)) page = made.release();
  }
  return {page->data() + std::size_t{tile % TileGrid::kPageTiles} * TileGrid::kTileTexels, TileGrid::kTileTexels};
}

void MaterialAtlas::read_tile(int material, TileIndex tile, std::span<std::uint16_t, TileGrid::kTileTexels> out) const {
  const std::span<const std::uint16_t> stored = this->tile(material, tile);
  for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
    out[i] = stored.empty() ? original(material, tile * TileGrid::kTileTexels + i) : stored[i];
  }
}

std::span<const std::uint16_t> MaterialAtlas::page(int material, std::uint32_t index) const {
  const Pages::Page* page = pages_->pages[page_slot(surface_->grid(), material, index)].load(std::memory_order_acquire);
  return page ? std::span<const std::uint16_t>(*page) : std::span<const std::uint16_t>();
}

std::int64_t MaterialAtlas::mass(int material, const RunControl& control) const {
  return parallel_reduce(
      std::int64_t{surface_->grid().num_texels()}, TileGrid::kPageTexels, control, std::int64_t{0},
      [&](std::int64_t begin, std::int64_t end) {
        std::int64_t sum = 0;
        for (std::int64_t i = begin; i < end; ++i) {
          const auto t = static_cast<TexelIndex>(i);
          if (surface_->is_covered(t)) sum += std::int64_t{amount(material, t)} * surface_->weight(t);
        }
        return sum;
      },
      [](std::int64_t a, std::int64_t b) { return a + b; });
}

std::string MaterialAtlas::hash() const {
  ContentHash hash;
  std::array<std::uint16_t, TileGrid::kTileTexels> values{};
  for (int m = 0; m < num_materials_; ++m) {
    for (TileIndex t = 0; t < surface_->grid().num_tiles(); ++t) {
      read_tile(m, t, values);
      hash.add(std::as_bytes(std::span(values)));
    }
  }
  return hash.hex();
}

std::size_t MaterialAtlas::memory() const {
  std::size_t bytes = 0;
  for (const auto& page : pages_->pages) bytes += page.load() ? sizeof(Pages::Page) : 0;
  return bytes;
}

}  // namespace patinate::simulation
