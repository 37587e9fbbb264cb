#include "simulation/transport/exchange.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "simulation/transport/pieces.h"
#include "simulation/transport/region_exchange.h"
#include "simulation/transport/regions.h"
#include "simulation/transport/splat.h"

namespace patinate::simulation {

namespace {

constexpr std::int64_t kPlaceChunk = 4096;  ///< Contacts.
constexpr std::int64_t kShapesAhead = 16;   ///< Contacts that memory is asked for before their turn.
constexpr std::size_t kFew = 64;            ///< Contacts or pieces that one thread is done with before another begins.

/// Width of a splat, in texels of the median size: 3 and 5 are those that one and two steps of a walk reach.
double width_of(const ExchangeOptions& options, const SurfaceAtlas& surface) {
  if (options.splat_mm > 0.0) return options.splat_mm / surface.median_texel_size_mm();
  return options.splat_texels == 5 ? 3.0 * std::numbers::sqrt2 : options.splat_texels;
}

[[nodiscard]] bool is_wide(const ExchangeOptions& options) {
  return options.splat_mm > 0.0 || options.splat_texels > 1;
}

}  // namespace

struct Exchanger::State {
  std::vector<Contact> ends;
  int num_materials;
  std::uint64_t seed;
  transport::SplatKernel kernel;
  std::optional<Regions> regions;
  std::vector<Contact> by_gammaton;
  std::vector<std::uint16_t> region_of;  ///< By contact; kNone where its splat lies in several, or near a seam:
  std::vector<std::uint16_t> sizes;      ///< By contact: of its splat; 0 = a texel.
  std::vector<Contact> cut_contacts;     ///< those.
  RegionLists contact_lists, piece_lists;
  Pieces pieces;
  std::vector<std::uint64_t> dirty_pages;  ///< A bit for each tile; 0 between calls.
  std::vector<TileIndex> dirty;
  std::vector<RegionWorker> workers;

  /// Finds the region of each contact's splat, or that it has to be cut.
  void place(std::span<const Contact> contacts, const SplatShape& shape, const SurfaceAtlas& surface,
             const RunControl& control);
};

void Exchanger::State::place(std::span<const Contact> contacts, const SplatShape& shape, const SurfaceAtlas& surface,
                             const RunControl& control) {
  const TileGrid& grid = surface.grid();
  parallel_for(static_cast<std::int64_t>(contacts.size()), kPlaceChunk, control,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   const auto c = static_cast<std::size_t>(i);
                   if (i + kShapesAhead < end) shape.prefetch(contacts[c + kShapesAhead].texel);
                   const TexelIndex texel = contacts[c].texel;
                   const int size = shape.size_at(texel), x = grid.x(texel), y = grid.y(texel);
                   const int reach = size == 0 ? 0 : SplatShape::stencil_of(size).reach;
                   const bool is_whole = size == 0 || (shape.is_plain(x, y, reach) && regions->holds(x, y, reach));
                   sizes[c] = static_cast<std::uint16_t>(size);
                   region_of[c] = is_whole ? static_cast<std::uint16_t>(regions->region_of(texel)) : RegionLists::kNone;
                 }
               });
}

double contact_area(const ExchangeOptions& options, const SurfaceAtlas& surface) {
  if (!(options.splat_mm > 0.0)) return 1.0;
  const double side = options.splat_mm / 3.0 / surface.median_texel_size_mm();
  return side * side;
}

SplatWidths splat_widths(const ExchangeOptions& options, const SurfaceAtlas& surface) {
  const double width = width_of(options, surface);
  return {.contact = is_wide(options) ? width : 0.0, .deposit = width};
}

std::optional<SplatShape> splat_shape(const ExchangeOptions& options, const SurfaceAtlas& surface) {
  if (!is_wide(options)) return std::nullopt;
  return SplatShape(surface, width_of(options, surface));
}

double reached_from(const ExchangeOptions& options, const SurfaceAtlas& surface, std::uint32_t weight) {
  const double area = static_cast<double>(weight) / SurfaceAtlas::kMedianWeight;
  const std::optional<SplatShape> shape = splat_shape(options, surface);
  if (!shape) return area;
  const int size = shape->size_of(weight);
  return size == 0 ? area : area * static_cast<double>(SplatShape::stencil_of(size).parts.size());
}

Exchanger::Exchanger(int num_materials, std::uint64_t seed, InstructionSet set) : state_(std::make_unique<State>()) {
  if (!has_instruction_set(set))
    throw InvalidInput("this machine lacks " + std::string(kInstructionSetNames[static_cast<std::size_t>(set)]));
  state_->kernel = transport::splat_kernel(set);
  state_->num_materials = num_materials;
  state_->seed = seed;
}
Exchanger::~Exchanger() = default;
Exchanger::Exchanger(Exchanger&&) noexcept = default;
Exchanger& Exchanger::operator=(Exchanger&&) noexcept = default;

ExchangeReport Exchanger::exchange(std::span<const Contact> contacts, const ExchangeOptions& options, ExchangeTime time,
                                   Cargo& cargo, MaterialAtlas& atlas, ParameterMaps* maps, const RunControl& control) {
  return run(contacts, {}, options, time, cargo, atlas, maps, control);
}

ExchangeReport Exchanger::deposit(std::span<const Ending> endings, const ExchangeOptions& options, ExchangeTime time,
                                  Cargo& cargo, MaterialAtlas& atlas, ParameterMaps* maps, const RunControl& control) {
  std::vector<Contact>& ends = state_->ends;
  ends.clear();
  for (const Ending& e : endings) ends.push_back({.texel = e.trail.texel(e.trail.size() - 1), .gammaton = e.gammaton});
  return run(ends, endings, options, time, cargo, atlas, maps, control);
}

ExchangeReport Exchanger::run(std::span<const Contact> contacts, std::span<const Ending> endings,
                              const ExchangeOptions& options, ExchangeTime time, Cargo& cargo, MaterialAtlas& atlas,
                              ParameterMaps* maps, const RunControl& control) {
  State& s = *state_;
  RunControl threads;  // a part of an exchange is no state to stop in
  threads.num_threads = control.num_threads;
  const auto comes_before = [](const Contact& a, const Contact& b) { return a.gammaton < b.gammaton; };
  if (!std::is_sorted(contacts.begin(), contacts.end(), comes_before)) {
    s.by_gammaton.assign(contacts.begin(), contacts.end());
    std::sort(s.by_gammaton.begin(), s.by_gammaton.end(), comes_before);
    contacts = s.by_gammaton;
  }
  std::array<int, kMaxMaterials> active_materials{};
  std::size_t num_active = 0;
  for (int m = 0; m < s.num_materials; ++m) {
    const bool takes_time = endings.empty();
    if (options.rates[m] > 0.0 && (options.contact > 0.0 || !takes_time)) active_materials[num_active++] = m;
  }
  const SurfaceAtlas& surface = atlas.surface();
  const std::span<const int> active = std::span(active_materials).first(num_active);
  const bool is_deposit = !endings.empty();
  const double width = width_of(options, surface);
  const bool has_splats = is_wide(options);
  ParameterMaps* const kept = maps != nullptr && maps->choice().has_any() ? maps : nullptr;
  const std::uint32_t columns = Regions::columns_for(thread_count(threads));
  if (!s.regions || s.regions->grid().width != surface.grid().width ||
      s.regions->grid().height != surface.grid().height || s.regions->most_columns() != columns) {
    s.regions.emplace(surface.grid(), columns);
    s.dirty_pages.assign(surface.grid().num_pages(), 0);
  }

  s.cut_contacts.clear();
  s.region_of.resize(is_deposit ? 0 : contacts.size());
  s.sizes.resize(s.region_of.size());
  if (is_deposit) {
    s.cut_contacts.assign(contacts.begin(), contacts.end());
  } else if (has_splats) {
    s.place(contacts, s.pieces.shape_of(surface, width, 0), surface, threads);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (s.region_of[i] == RegionLists::kNone) s.cut_contacts.push_back(contacts[i]);
    }
  } else {
    for (std::size_t i = 0; i < contacts.size(); ++i)
      s.region_of[i] = static_cast<std::uint16_t>(s.regions->region_of(contacts[i].texel));
  }
  s.contact_lists.fill(s.region_of, s.regions->size(), threads);
  const WideContacts wide{.surface = surface,
                          .contacts = s.cut_contacts,
                          .endings = endings,
                          .active = active,
                          .seed = s.seed,
                          .random_key = time.random_key};
  s.pieces.cut(wide, width, *s.regions, cargo, threads);
  s.piece_lists.fill(s.pieces.regions(), s.regions->size(), threads);

  const RegionCall call{.seed = s.seed,
                        .iteration = time.iteration,
                        .random_key = time.random_key,
                        .active = active,
                        .cargo = cargo,
                        .atlas = atlas,
                        .regions = *s.regions,
                        .maps = kept,
                        .is_deposit = is_deposit,
                        .is_wide = has_splats,
                        .kernel = s.kernel,
                        .contacts = contacts,
                        .sizes = s.sizes,
                        .contact_lists = s.contact_lists,
                        .cut_contacts = s.cut_contacts,
                        .pieces = s.pieces.pieces(),
                        .piece_mass = s.pieces.mass(),
                        .piece_randoms = s.pieces.randoms(),
                        .piece_lists = s.piece_lists,
                        .dirty_pages = s.dirty_pages};
  const std::int64_t num_regions = s.regions->size();
  const std::int64_t num_workers = contacts.size() + s.pieces.pieces().size() < kFew
                                       ? 1
                                       : std::clamp<std::int64_t>(thread_count(threads), 1, num_regions);
  if (s.workers.size() < static_cast<std::size_t>(num_workers)) s.workers.resize(num_workers);
  std::atomic<std::int64_t> next{0};
  parallel_for(num_workers, 1, threads, [&](std::int64_t w, std::int64_t) {
    RegionWorker& worker = s.workers[w];
    worker.table.reset(options, contact_area(options, surface), active);
    for (std::int64_t region = next++; region < num_regions; region = next++)
      exchange_region(call, static_cast<std::uint32_t>(region), worker);
  });
  s.pieces.join(wide, cargo, threads);

  ExchangeReport report;
  s.dirty.clear();
  for (std::uint32_t page = 0; page < s.dirty_pages.size(); ++page) {
    for (std::uint64_t bits = std::exchange(s.dirty_pages[page], 0); bits != 0; bits &= bits - 1)
      s.dirty.push_back(page * TileGrid::kPageTiles + static_cast<std::uint32_t>(std::countr_zero(bits)));
  }
  report.dirty_tiles = s.dirty;
  for (RegionWorker& worker : s.workers) {
    for (std::size_t m = 0; m < kMaxMaterials; ++m) {
      report.dropped[m] += std::exchange(worker.dropped[m], 0);
      report.picked_up[m] += std::exchange(worker.picked_up[m], 0);
    }
  }
  return report;
}

}  // namespace patinate::simulation
