#include "simulation/transport/region_exchange.h"

#include <algorithm>

#include "simulation/transport/transfer.h"

namespace patinate::simulation {

namespace {

using transport::SplatLanes;
using transport::SplatSums;

constexpr std::uint32_t kMaxMass = 0xFFFFFFFFu;
constexpr std::uint32_t kNoPart = 0xFFFFFFFFu;  ///< Part of a lane that a splat leaves out.
constexpr std::size_t kAhead =
    8;  ///< Contacts that memory is asked for before their turn; their numbers at twice that.

using transfer_kernel::deposited_quanta;
using transfer_kernel::limit_of_part;
using transfer_kernel::mixed_with;

class RegionExchange {
 public:
  RegionExchange(const RegionCall& call, RegionWorker& worker)
      : call_(call), worker_(worker), surface_(call.atlas.surface()), num_active_(call.active.size()) {
    worker.pages.assign(call.regions.pages_each() * num_active_, nullptr);
    worker.is_known.assign(call.regions.pages_each(), 0);
  }

  /// Asks memory for what a contact with its splat will need.
  void prefetch(const Contact& contact, int size) {
    __builtin_prefetch(call_.cargo.mass[contact.gammaton].data(), 1);
    const TileGrid& grid = surface_.grid();
    const int x = grid.x(contact.texel), y = grid.y(contact.texel);
    const int reach = size == 0 ? 0 : SplatShape::stencil_of(size).reach;
    // A line of memory has four rows of a tile, of amounts and of weights alike.
    for (int row = (y - reach) & ~3; row <= y + reach; row += 4) {
      for (int column = (x - reach) & ~7; column <= x + reach; column += TileGrid::kTileSide) {
        const TexelIndex texel = grid.index(column, row);
        surface_.prefetch_weight(texel);
        std::uint16_t* const* const pages = pages_of(TileGrid::page_of(texel));
        for (std::size_t a = 0; a < num_active_; ++a) {
          if (pages[a]) __builtin_prefetch(pages[a] + texel % TileGrid::kPageTexels, 1);
        }
      }
    }
  }

  /// A contact with its whole splat: all texels at once.
  void exchange(const Contact& contact, int size) {
    const TileGrid& grid = surface_.grid();
    const SplatStencil& stencil = SplatShape::stencil_of(size);
    const SplatPlace place(grid, stencil, grid.x(contact.texel), grid.y(contact.texel));
    const std::array<std::uint32_t, 4> pages = place.pages();
    SplatLanes lanes = lay(contact.texel, size, stencil, place);
    const double* shares = lanes.up;
    const auto num_lanes = static_cast<std::size_t>(stencil.num_lanes);
    std::fill_n(worker_.any.begin(), num_lanes + SplatPlace::kSlack, std::uint16_t{0});
    Masses& cargo = call_.cargo.mass[contact.gammaton];
    const Masses randoms =
        transfer_randoms(call_.seed, contact.gammaton, call_.random_key, 0, static_cast<int>(num_active_));
    bool is_dirty = false;
    for (std::size_t a = 0; a < num_active_; ++a, shares += 2 * num_lanes) {
      const auto m = static_cast<std::size_t>(call_.active[a]);
      SplatPlace::Pages<std::uint16_t> amounts = amounts_of(pages, a);
      place.gather(or_originals(amounts, a, contact.texel), worker_.amount.data());
      lanes.whole = cargo[m];
      lanes.room = (kMaxMass - lanes.whole) / static_cast<std::uint32_t>(SplatShape::kMaxParts);
      lanes.random = randoms[a];
      lanes.up = shares;
      lanes.down = shares + num_lanes;
      lanes.quanta = worker_.quanta[a].data();
      SplatSums sums;
      call_.kernel(lanes, sums);
      if (sums.picked_up == 0 && sums.dropped == 0) continue;
      is_dirty = true;
      cargo[m] += static_cast<std::uint32_t>(sums.picked_up - sums.dropped);
      worker_.picked_up[m] += sums.picked_up;
      worker_.dropped[m] += sums.dropped;
      make_pages(place, pages, a, amounts);
      place.scatter(worker_.left.data(), amounts);
    }
    if (is_dirty) mark(place, pages);
    if (call_.maps) record(place, pages, lanes);
  }

  /// Exchanges a splat of few texels, one after the other: lanes take longer to lay out than those to exchange.
  void exchange_few(const Contact& contact, int size) {
    const std::size_t num_parts = lay_few(contact.texel, size);
    Masses& cargo = call_.cargo.mass[contact.gammaton];
    const Masses randoms =
        transfer_randoms(call_.seed, contact.gammaton, call_.random_key, 0, static_cast<int>(num_active_));
    Masses whole{};
    for (std::size_t a = 0; a < num_active_; ++a) {
      whole[a] = cargo[call_.active[a]];
      deal(
          whole[a], randoms[a], worker_.parts[0].weight, num_parts,
          [&](std::size_t k) { return worker_.parts[k].share; },
          [&](std::size_t k, std::uint32_t mass) { worker_.mass[a][k] = mass; });
    }
    Masses sum{};
    for (std::size_t k = 0; k < num_parts; ++k) {
      const RegionWorker::Part& part = worker_.parts[k];
      const TransferShares* shares = worker_.table.find(part.weight, part.share);
      exchange_texel(
          part.texel, part.weight, k == 0,
          [&](std::size_t a, std::uint32_t amount, std::uint32_t& mass) {
            mass = worker_.mass[a][k];
            return transfer_quanta(shares[a], amount, part.weight, mass,
                                   mixed_with(randoms[a], static_cast<std::uint32_t>(k)),
                                   limit_of_part(whole[a], mass));
          },
          [&](std::size_t a, std::uint32_t mass) { sum[a] += mass; });
    }
    for (std::size_t a = 0; a < num_active_; ++a) cargo[call_.active[a]] = sum[a];
  }

  /// A contact of one texel that is not cut.
  void exchange(const Contact& contact) {
    Masses& cargo = call_.cargo.mass[contact.gammaton];
    const Masses randoms =
        transfer_randoms(call_.seed, contact.gammaton, call_.random_key, 0, static_cast<int>(num_active_));
    const std::uint32_t weight = surface_.weight(contact.texel);
    const TransferShares* shares = worker_.table.find(weight, SplatShape::kWhole);
    exchange_texel(
        contact.texel, weight, true,
        [&](std::size_t a, std::uint32_t amount, std::uint32_t& mass) {
          mass = cargo[call_.active[a]];
          return transfer_quanta(shares[a], amount, weight, mass, randoms[a], kMaxMass);
        },
        [&](std::size_t a, std::uint32_t mass) { cargo[call_.active[a]] = mass; });
  }

  /// A piece of a contact or of an ending.
  void exchange_piece(std::uint32_t number) {
    const Piece& piece = call_.pieces[number];
    std::uint32_t* const masses = call_.piece_mass.data() + std::size_t{number} * num_active_;
    const std::uint32_t weight = surface_.weight(piece.texel);
    const auto put = [&](std::size_t a, std::uint32_t mass) { masses[a] = mass; };
    if (call_.is_deposit) {
      exchange_texel(
          piece.texel, weight, false,
          [&](std::size_t a, std::uint32_t amount, std::uint32_t& mass) {
            mass = masses[a];
            return deposited_quanta(amount, weight, mass);
          },
          put);
      return;
    }
    const TransferShares* shares = worker_.table.find(weight, piece.share);
    const Masses& randoms = call_.piece_randoms[piece.contact];
    const Masses& cargo = call_.cargo.mass[call_.cut_contacts[piece.contact].gammaton];
    exchange_texel(
        piece.texel, weight, piece.number == 0,
        [&](std::size_t a, std::uint32_t amount, std::uint32_t& mass) {
          mass = masses[a];
          return transfer_quanta(shares[a], amount, weight, mass, mixed_with(randoms[a], piece.number),
                                 limit_of_part(cargo[call_.active[a]], mass));
        },
        put);
  }

 private:
  /// The parts of a splat away from seams. @returns how many they are.
  std::size_t lay_few(TexelIndex texel, int size) {
    const std::uint32_t weight = surface_.weight(texel);
    if (size == 0) {
      worker_.parts[0] = {texel, weight, SplatShape::kWhole};
      return 1;
    }
    const SplatStencil& stencil = SplatShape::stencil_of(size);
    const TileGrid& grid = surface_.grid();
    const int x = grid.x(texel), y = grid.y(texel);
    std::uint32_t rest = SplatShape::kWhole;
    std::size_t num = 1;
    for (std::size_t k = 1; k < stencil.parts.size(); ++k) {
      const SplatStencil::Part& part = stencil.parts[k];
      const TexelIndex there = grid.index(x + part.x, y + part.y);
      const std::uint32_t other = surface_.weight(there);
      const std::uint32_t share = SplatShape::balanced(part.share, weight, other);
      if (share == 0) continue;
      worker_.parts[num++] = {there, other, share};
      rest -= share;
    }
    worker_.parts[0] = {texel, weight, rest};
    return num;
  }

  using Numbers = std::array<std::uint32_t, 4>;  ///< Numbers of pages, as SplatPlace has them.

  /// Weights and shares of a splat away from seams; `up` is what ShareTable::even() gives, of all materials.
  [[nodiscard]] SplatLanes lay(TexelIndex texel, int size, const SplatStencil& stencil, const SplatPlace& place) {
    SplatPlace::Pages<const std::uint16_t> weights;
    const Numbers pages = place.pages();
    for (std::size_t i = 0; i < pages.size(); ++i)
      weights[i] = surface_.weights().data() + std::size_t{pages[i]} * TileGrid::kPageTexels;
    place.gather(weights, worker_.weight.data());
    const std::size_t num = stencil.parts.size(), num_lanes = static_cast<std::size_t>(stencil.num_lanes);
    std::fill(worker_.weight.begin() + static_cast<std::ptrdiff_t>(num),
              worker_.weight.begin() + static_cast<std::ptrdiff_t>(num_lanes), std::uint16_t{1});
    const std::uint32_t weight = surface_.weight(texel);
    unsigned differences = 0;
    for (std::size_t l = 0; l < num; ++l) differences |= worker_.weight[l] ^ weight;
    SplatLanes lanes{.num = stencil.num_lanes,
                     .middle = stencil.middle,
                     .number = stencil.number.data(),
                     .before = stencil.before.data(),
                     .after = stencil.after.data(),
                     .weight = worker_.weight.data(),
                     .middle_weight = weight,
                     .is_even = differences == 0,
                     .amount = worker_.amount.data(),
                     .left = worker_.left.data(),
                     .any = worker_.any.data()};
    if (lanes.is_even) {
      lanes.up = worker_.table.even(stencil, size, weight);
      return lanes;
    }
    lay_uneven(stencil, weight);
    lanes.number = worker_.number.data();
    lanes.before = worker_.before.data();
    lanes.after = worker_.after.data();
    lanes.up = worker_.shares.data();
    return lanes;
  }

  /// Where areas differ: what goes to smaller texels is less, some of them are left out, and the middle has the rest.
  void lay_uneven(const SplatStencil& stencil, std::uint32_t weight) {
    const auto num_lanes = static_cast<std::size_t>(stencil.num_lanes);
    worker_.shares.assign(2 * num_lanes * num_active_, 0.0);
    std::fill_n(worker_.number.begin(), num_lanes, kNoPart);
    std::fill_n(worker_.before.begin(), num_lanes, 0u);
    std::fill_n(worker_.after.begin(), num_lanes, 0u);
    std::uint32_t sum = 0, num = 1;
    for (std::size_t k = 1; k < stencil.parts.size(); ++k) {
      const std::size_t lane = stencil.lane_of[k];
      const std::uint32_t other = worker_.weight[lane];
      const std::uint32_t share = SplatShape::balanced(stencil.parts[k].share, weight, other);
      if (share == 0) continue;
      worker_.number[lane] = num++;
      worker_.before[lane] = sum;
      worker_.after[lane] = sum += share;
      worker_.table.put(worker_.table.find(other, share), num_lanes, lane, worker_.shares.data());
    }
    // The middle comes first.
    const std::uint32_t rest = SplatShape::kWhole - sum;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) worker_.before[lane] += rest;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) worker_.after[lane] += rest;
    const auto middle = static_cast<std::size_t>(stencil.middle);
    worker_.number[middle] = 0;
    worker_.before[middle] = 0;
    worker_.table.put(worker_.table.find(weight, rest), num_lanes, middle, worker_.shares.data());
  }

  [[nodiscard]] SplatPlace::Pages<std::uint16_t> amounts_of(const Numbers& pages, std::size_t a) {
    SplatPlace::Pages<std::uint16_t> out;
    for (std::size_t i = 0; i < pages.size(); ++i) out[i] = pages_of(pages[i])[a];
    return out;
  }

  /// For pages that are not there: one that holds the originals. All texels of a stencil are of one object.
  [[nodiscard]] SplatPlace::Pages<const std::uint16_t> or_originals(const SplatPlace::Pages<std::uint16_t>& amounts,
                                                                    std::size_t a, TexelIndex texel) {
    SplatPlace::Pages<const std::uint16_t> out;
    std::vector<std::uint16_t>& page = worker_.originals[a];
    for (std::size_t i = 0; i < amounts.size(); ++i) {
      out[i] = amounts[i];
      if (out[i] != nullptr) continue;
      const std::uint16_t original = call_.atlas.original(call_.active[a], texel);
      if (page.empty() || page[0] != original) page.assign(TileGrid::kPageTexels, original);
      out[i] = page.data();
    }
    return out;
  }

  /// Those that are missing where an amount has changed.
  void make_pages(const SplatPlace& place, const Numbers& pages, std::size_t a,
                  SplatPlace::Pages<std::uint16_t>& amounts) {
    if (std::find(amounts.begin(), amounts.end(), nullptr) == amounts.end()) return;
    const std::int32_t* quanta = worker_.quanta[a].data();
    place.each_piece([&](std::uint32_t page, std::uint32_t, std::uint32_t lane, std::uint32_t num) {
      if (amounts[page] != nullptr || std::all_of(quanta + lane, quanta + lane + num, [](int q) { return q == 0; }))
        return;
      amounts[page] = call_.atlas.writable_tile(call_.active[a], pages[page] * TileGrid::kPageTiles).data();
      pages_of(pages[page])[a] = amounts[page];
    });
  }

  /// The tiles in which something has changed.
  void mark(const SplatPlace& place, const Numbers& pages) {
    place.each_piece([&](std::uint32_t page, std::uint32_t texel, std::uint32_t lane, std::uint32_t num) {
      if (SplatPlace::some(worker_.any.data() + lane, num))
        call_.dirty_pages[pages[page]] |= std::uint64_t{1} << texel / TileGrid::kTileTexels;
    });
  }

  void record(const SplatPlace& place, const Numbers& pages, const SplatLanes& lanes) {
    place.each_piece([&](std::uint32_t page, std::uint32_t texel, std::uint32_t lane, std::uint32_t num) {
      for (std::uint32_t l = lane; l < lane + num; ++l, ++texel) {
        if (lanes.number[l] == kNoPart) continue;
        Masses dropped{};
        for (std::size_t a = 0; a < num_active_; ++a) {
          const std::int64_t mass = std::int64_t{worker_.quanta[a][l]} * worker_.weight[l];
          dropped[call_.active[a]] = mass < 0 ? static_cast<std::uint32_t>(-mass) : 0;
        }
        call_.maps->record(pages[page] << 12 | texel, call_.iteration, static_cast<int>(l) == lanes.middle, dropped);
      }
    });
  }

  /// The amounts of a page, by active material.
  [[nodiscard]] std::uint16_t** pages_of(std::uint32_t page) {
    const std::uint32_t place = call_.regions.place_of_page(page);
    std::uint16_t** const pages = worker_.pages.data() + place * num_active_;
    if (worker_.is_known[place] != 0) return pages;
    worker_.is_known[place] = 1;
    for (std::size_t a = 0; a < num_active_; ++a) {  // no one else makes pages of this region
      const int material = call_.active[a];
      if (!call_.atlas.page(material, page).empty())
        pages[a] = call_.atlas.writable_tile(material, page * TileGrid::kPageTiles).data();
    }
    return pages;
  }

  /// @param quanta_of  quanta_of(a, amount, mass): sets what is carried, and returns what leaves the texel.
  /// @param put        put(a, mass): what is carried then.
  template <class Quanta, class Put>
  void exchange_texel(TexelIndex texel, std::uint32_t weight, bool is_middle, Quanta&& quanta_of, Put&& put) {
    const std::uint32_t page = TileGrid::page_of(texel), in_page = texel % TileGrid::kPageTexels;
    std::uint16_t** const pages = pages_of(page);
    Masses dropped{};
    bool is_dirty = false;
    for (std::size_t a = 0; a < num_active_; ++a) {
      const int material = call_.active[a];
      const auto m = static_cast<std::size_t>(material);
      const std::uint32_t amount = pages[a] ? pages[a][in_page] : call_.atlas.original(material, texel);
      std::uint32_t mass = 0;
      const std::int32_t quanta = quanta_of(a, amount, mass);
      if (quanta != 0) {
        if (!pages[a]) pages[a] = call_.atlas.writable_tile(material, page * TileGrid::kPageTiles).data();
        pages[a][in_page] = static_cast<std::uint16_t>(static_cast<std::int32_t>(amount) - quanta);
        is_dirty = true;
        const std::int64_t moved = std::int64_t{quanta} * weight;
        mass += static_cast<std::uint32_t>(moved);
        if (quanta > 0) {
          worker_.picked_up[m] += moved;
        } else {
          dropped[m] = static_cast<std::uint32_t>(-moved);
          worker_.dropped[m] -= moved;
        }
      }
      put(a, mass);
    }
    if (is_dirty) call_.dirty_pages[page] |= std::uint64_t{1} << TileGrid::tile_of(texel) % TileGrid::kPageTiles;
    if (call_.maps && call_.is_deposit) call_.maps->record_deposit(texel, dropped);
    if (call_.maps && !call_.is_deposit) call_.maps->record(texel, call_.iteration, is_middle, dropped);
  }

  const RegionCall& call_;
  RegionWorker& worker_;
  const SurfaceAtlas& surface_;
  std::size_t num_active_;
};

}  // namespace

void exchange_region(const RegionCall& call, std::uint32_t region, RegionWorker& worker) {
  const std::span<const std::uint32_t> contacts = call.contact_lists.of(region), pieces = call.piece_lists.of(region);
  if (contacts.empty() && pieces.empty()) return;
  RegionExchange here(call, worker);
  const auto gammaton_of = [&](std::uint32_t piece) { return call.cut_contacts[call.pieces[piece].contact].gammaton; };
  auto piece = pieces.begin();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (i + 2 * kAhead < contacts.size()) __builtin_prefetch(&call.contacts[contacts[i + 2 * kAhead]]);
    if (i + kAhead < contacts.size()) {
      const std::uint32_t next = contacts[i + kAhead];
      here.prefetch(call.contacts[next], call.is_wide ? call.sizes[next] : 0);
    }
    const Contact& contact = call.contacts[contacts[i]];
    for (; piece != pieces.end() && gammaton_of(*piece) < contact.gammaton; ++piece) here.exchange_piece(*piece);
    const int size = call.is_wide ? call.sizes[contacts[i]] : 0;
    if (!call.is_wide) {
      here.exchange(contact);
    } else if (size == 0 || SplatShape::stencil_of(size).parts.size() <= RegionWorker::kFewParts) {
      here.exchange_few(contact, size);
    } else {
      here.exchange(contact, size);
    }
  }
  for (; piece != pieces.end(); ++piece) here.exchange_piece(*piece);
}

}  // namespace patinate::simulation
