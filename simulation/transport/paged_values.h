/// \file
/// A value for each texel in tile order, in pages of 64 x 64 texels that are made when first written, like those of
/// MaterialAtlas.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// A page that is not there holds 0. Several threads may make and write different tiles at once.
template <class T>
class PagedValues {
 public:
  using Page = std::array<T, TileGrid::kPageTexels>;

  explicit PagedValues(std::uint32_t num_pages) : pages_(num_pages) {}
  ~PagedValues() {
    for (std::atomic<Page*>& page : pages_) delete page.load();
  }
  PagedValues(const PagedValues&) = delete;
  PagedValues& operator=(const PagedValues&) = delete;

  [[nodiscard]] T value(TexelIndex t) const {
    const Page* page = pages_[TileGrid::page_of(t)].load(std::memory_order_acquire);
    return page ? (*page)[t % TileGrid::kPageTexels] : T{};
  }
  [[nodiscard]] T& at(TexelIndex t) { return writable_page(TileGrid::page_of(t))[t % TileGrid::kPageTexels]; }

  [[nodiscard]] std::uint32_t num_pages() const { return static_cast<std::uint32_t>(pages_.size()); }
  /// Empty when it is not there.
  [[nodiscard]] std::span<const T> page(std::uint32_t index) const {
    const Page* page = pages_[index].load(std::memory_order_acquire);
    return page ? std::span<const T>(*page) : std::span<const T>();
  }
  /// Made when missing.
  [[nodiscard]] std::span<T, TileGrid::kPageTexels> writable_page(std::uint32_t index) {
    Page* page = pages_[index].load(std::memory_order_acquire);
    if (!page) {
      auto made = std::make_unique<Page>();
      if (pages_[index].compare_exchange_strong(page, made.get(), std::memory_order_acq_rel)) page = made.release();
    }
    return *page;
  }
  /// Bytes of all pages.
  [[nodiscard]] std::size_t memory() const {
    std::size_t bytes = 0;
    for (const auto& page : pages_) bytes += page.load() ? sizeof(Page) : 0;
    return bytes;
  }

 private:
  std::vector<std::atomic<Page*>> pages_;
};

}  // namespace patinate::simulation
