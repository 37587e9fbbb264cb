/// \file
/// What a simulation remembers of each texel beyond its materials, for transfer and comparison; only what is asked for.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "patinate/simulation/scene.h"
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

struct ParameterMapChoice {
  bool hits = false;       ///< Contacts ever (of a wide splat: at its middle).
  bool last_hit = false;   ///< 1 + the last iteration with a contact; 0 = never.
  bool residence = false;  ///< Iterations in which something was there, however much: the "time of wetness".
  std::array<bool, kMaxMaterials> deposited{};  ///< Mass ever dropped there, whatever happened to it since.

  [[nodiscard]] bool has_any() const {
    return hits || last_hit || residence || std::find(deposited.begin(), deposited.end(), true) != deposited.end();
  }
};

/// Maps in tile order; pages appear with the first contact. A map that was not asked for is null.
class ParameterMaps {
 public:
  ParameterMaps(const TileGrid& grid, const ParameterMapChoice& choice);

  [[nodiscard]] const ParameterMapChoice& choice() const { return choice_; }
  /// Records one contact. Texels of different tiles may be recorded by several threads at once; those of one tile
  /// in a fixed order.
  /// @param is_middle  Whether this is the middle of the gammaton's splat.
  /// @param dropped    Mass by material that went to the texel.
  void record(TexelIndex texel, std::int64_t iteration, bool is_middle,
              const std::array<std::uint32_t, kMaxMaterials>& dropped);

  /// Mass that went to the texel without a contact of its own.
  void record_deposit(TexelIndex texel, const std::array<std::uint32_t, kMaxMaterials>& dropped);

  [[nodiscard]] PagedValues<std::uint32_t>* hits() const { return hits_.get(); }
  /// There when last_hit or residence is asked for.
  [[nodiscard]] PagedValues<std::uint32_t>* last_hit() const { return last_hit_.get(); }
  [[nodiscard]] PagedValues<std::uint32_t>* residence() const { return residence_.get(); }
  [[nodiscard]] PagedValues<std::uint64_t>* deposited(int material) const { return deposited_[material].get(); }
  /// Bytes of all pages.
  [[nodiscard]] std::size_t memory() const;

 private:
  ParameterMapChoice choice_;
  std::unique_ptr<PagedValues<std::uint32_t>> hits_;
  std::unique_ptr<PagedValues<std::uint32_t>> last_hit_;
  std::unique_ptr<PagedValues<std::uint32_t>> residence_;
  std::array<std::unique_ptr<PagedValues<std::uint64_t>>, kMaxMaterials> deposited_;
};

}  // namespace patinate::simulation
