#include "simulation/transport/region_exchange.h"

#include <algorithm>

#include "simulation/transport/transfer.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kMaxMass = 0xFFFFFFFFu;
constexpr std::size_t kAhead =
    8;  ///< Contacts that memory is asked for before their turn; their numbers at twice that.

/// What a piece of a gammaton may hold: all pieces together no more than their gammaton may.
[[nodiscard]] std::uint32_t limit_of(std::uint32_t whole, std::uint32_t mass) {
  return mass + (kMaxMass - whole) / static_cast<std::uint32_t>(SplatShape::kMaxParts);
}

/// All that is carried, below 0: as much of it as fits.
[[nodiscard]] std::int32_t deposit_quanta(std::uint32_t amount, std::uint32_t weight, std::uint32_t mass) {
  return -static_cast<std::int32_t>(std::min(mass / weight, kMaxAmount - amount));
}

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

  /// A contact with its whole splat.
  void exchange(const Contact& contact, int size) {
    const std::size_t num_parts = lay(contact.texel, size);
    Masses& cargo = call_.cargo.mass[contact.gammaton];
    const Masses randoms =
        transfer_randoms(call_.seed, contact.gammaton, call_.random_key, 0, static_cast<int>(num_active_));
    Masses whole{};
    for (std::size_t a = 0; a < num_active_; ++a) {
      whole[a] = cargo[static_cast<std::size_t>(call_.active[a])];
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
                                   mixed(randoms[a], static_cast<std::uint32_t>(k)), limit_of(whole[a], mass));
          },
          [&](std::size_t a, std::uint32_t mass) { sum[a] += mass; });
    }
    for (std::size_t a = 0; a < num_active_; ++a) cargo[static_cast<std::size_t>(call_.active[a])] = sum[a];
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
          mass = cargo[static_cast<std::size_t>(call_.active[a])];
          return transfer_quanta(shares[a], amount, weight, mass, randoms[a], kMaxMass);
        },
        [&](std::size_t a, std::uint32_t mass) { cargo[static_cast<std::size_t>(call_.active[a])] = mass; });
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
            return deposit_quanta(amount, weight, mass);
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
          return transfer_quanta(shares[a], amount, weight, mass, mixed(randoms[a], piece.number),
                                 limit_of(cargo[static_cast<std::size_t>(call_.active[a])], mass));
        },
        put);
  }

 private:
  /// The parts of a splat away from seams. @returns how many they are.
  std::size_t lay(TexelIndex texel, int size) {
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
    if (call.is_wide) {
      here.exchange(contact, call.sizes[contacts[i]]);
    } else {
      here.exchange(contact);
    }
  }
  for (; piece != pieces.end(); ++piece) here.exchange_piece(*piece);
}

}  // namespace patinate::simulation
