#include "simulation/transport/exchange.h"

#include <algorithm>
#include <atomic>
#include <numbers>
#include <utility>
#include <vector>

#include "libcommon/core/parallel.h"
#include "simulation/transport/contact_sort.h"
#include "simulation/transport/pieces.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kMaxMass = 0xFFFFFFFFu;
/// transfer_shares() of the weights and shares that turn up: a few hundred of them serve a million contacts.
class ShareTable {
 public:
  /// @param area  Of a contact, in texels of median size.
  void reset(const ExchangeOptions& options, double area, std::span<const int> active) {
    const bool is_same = !keys_.empty() && options.ratio == options_.ratio && options.contact == options_.contact &&
                         options.rates == options_.rates && area == area_;
    if (is_same && std::equal(active.begin(), active.end(), active_.begin(), active_.end())) return;
    options_ = options;
    area_ = area;
    active_.assign(active.begin(), active.end());
    keys_.assign(kSize, 0);
    shares_.resize(kSize * active.size());
  }
  /// By active material.
  [[nodiscard]] const TransferShares* find(std::uint32_t weight, std::uint32_t share) {
    const std::uint64_t key = std::uint64_t{weight} << 32 | share;
    const std::size_t slot = (weight * 0x85EBCA6Bu + share * 0x9E3779B1u) >> 20;  // shares are often multiples of 2^12
    TransferShares* found = shares_.data() + slot * active_.size();
    if (keys_[slot] != key) {
      keys_[slot] = key;
      for (std::size_t a = 0; a < active_.size(); ++a) {
        found[a] = transfer_shares(options_.ratio, options_.rates[static_cast<std::size_t>(active_[a])],
                                   options_.contact, weight, area_ * share / SplatShape::kWhole);
      }
    }
    return found;
  }

 private:
  static constexpr std::size_t kSize = 4096;  ///< 2^12: find() takes so many bits of a hash.
  ExchangeOptions options_;
  double area_ = 1.0;
  std::vector<int> active_;
  std::vector<std::uint64_t> keys_;
  std::vector<TransferShares> shares_;
};

/// What one thread needs; which thread it is shows in no result.
struct Worker {
  ShareTable table;
  ContactSort::Scratch scratch;
  std::array<std::int64_t, kMaxMaterials> dropped{};
  std::array<std::int64_t, kMaxMaterials> picked_up{};
};

/// What all contacts of a call share.
struct Call {
  std::uint64_t seed;
  ExchangeTime time;
  std::span<const int> active;
  Cargo& cargo;
  MaterialAtlas& atlas;
  ParameterMaps* maps;
  bool is_deposit;
  std::span<const Contact> contacts;
  // Empty when carriers are gammatons.
  std::span<const Piece> pieces;        ///< By the keys' carrier.
  std::span<std::uint32_t> piece_mass;  ///< By carrier and active material.
  std::span<const Masses> randoms;      ///< By contact.
};

constexpr std::size_t kBatch = 16;

/// What some contacts need, read for all of them before the first is worked on: memory is far away, and waits for many
/// at once.
struct Batch {
  std::array<std::uint32_t, kBatch> weight;
  std::array<std::array<const std::uint16_t*, kMaxMaterials>, kBatch>
      stored;  ///< By active material: the tile's; null: the originals.
  std::array<Masses, kBatch> randoms;
};

[[nodiscard]] std::uint32_t* mass_of(const Call& call, std::uint32_t carrier) {
  return call.pieces.empty() ? call.cargo.mass[carrier].data()
                             : call.piece_mass.data() + std::size_t{carrier} * call.active.size();
}

void prepare(const Call& call, std::span<const ContactKey> keys, Batch& batch) {
  const SurfaceAtlas& surface = call.atlas.surface();
  const auto texel = [&](std::size_t i) { return static_cast<TexelIndex>(keys[i] >> 32); };
  for (std::size_t i = 0; i < keys.size(); ++i) {
    __builtin_prefetch(mass_of(call, static_cast<std::uint32_t>(keys[i])), 1);
    if (!call.pieces.empty()) __builtin_prefetch(&call.pieces[static_cast<std::uint32_t>(keys[i])]);
    batch.weight[i] = surface.weight(texel(i));
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    for (std::size_t a = 0; a < call.active.size(); ++a) {
      batch.stored[i][a] = call.atlas.tile(call.active[a], TileGrid::tile_of(texel(i))).data();
      if (batch.stored[i][a]) __builtin_prefetch(batch.stored[i][a] + texel(i) % TileGrid::kTileTexels, 1);
    }
  }
  for (std::size_t i = 0; i < keys.size() && !call.is_deposit; ++i) {
    const auto carrier = static_cast<std::uint32_t>(keys[i]);
    if (call.pieces.empty()) {
      batch.randoms[i] =
          transfer_randoms(call.seed, carrier, call.time.random_key, 0, static_cast<int>(call.active.size()));
      continue;
    }
    const Piece& piece = call.pieces[carrier];
    for (std::size_t a = 0; a < call.active.size(); ++a)
      batch.randoms[i][a] = mixed(call.randoms[piece.contact][a], piece.number);
  }
}

/// What a gammaton, or a piece of one, may hold: all pieces together no more than their gammaton may.
[[nodiscard]] std::uint32_t limit_of(const Call& call, const Piece* piece, std::size_t material, std::uint32_t mass) {
  if (piece == nullptr) return kMaxMass;
  const std::uint32_t whole = call.cargo.mass[call.contacts[piece->contact].gammaton][material];
  return mass + (kMaxMass - whole) / static_cast<std::uint32_t>(SplatShape::kMaxParts);
}

/// All that is carried, below 0: as much of it as fits.
[[nodiscard]] std::int32_t deposit_quanta(std::uint32_t amount, std::uint32_t weight, std::uint32_t mass) {
  return -static_cast<std::int32_t>(std::min(mass / weight, kMaxAmount - amount));
}

/// Exchanges one section's contacts. @returns how many dirty tiles it wrote to `dirty`.
std::size_t exchange_section(const Call& call, std::span<const ContactKey> keys, Worker& worker, TileIndex* dirty) {
  Batch batch;
  std::size_t num_dirty = 0;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k % kBatch == 0) prepare(call, keys.subspan(k, std::min(kBatch, keys.size() - k)), batch);
    const std::size_t b = k % kBatch;
    const auto texel = static_cast<TexelIndex>(keys[k] >> 32);
    const auto carrier = static_cast<std::uint32_t>(keys[k]);
    const TileIndex tile = TileGrid::tile_of(texel);
    const Piece* piece = call.pieces.empty() ? nullptr : &call.pieces[carrier];
    std::uint32_t* const masses = mass_of(call, carrier);
    const std::uint32_t weight = batch.weight[b];
    const TransferShares* shares =
        call.is_deposit ? nullptr : worker.table.find(weight, piece ? piece->share : SplatShape::kWhole);
    const std::size_t in_tile = texel % TileGrid::kTileTexels;
    Masses dropped{};
    for (std::size_t a = 0; a < call.active.size(); ++a) {
      const int material = call.active[a];
      const auto m = static_cast<std::size_t>(material);
      std::uint32_t& mass = masses[piece ? a : m];
      // A page that was not there may have been made since.
      const std::uint16_t* stored = batch.stored[b][a] ? batch.stored[b][a] : call.atlas.tile(material, tile).data();
      const std::uint32_t amount = stored ? stored[in_tile] : call.atlas.original(material, texel);
      const std::int32_t quanta =
          call.is_deposit
              ? deposit_quanta(amount, weight, mass)
              : transfer_quanta(shares[a], amount, weight, mass, batch.randoms[b][a], limit_of(call, piece, m, mass));
      if (quanta == 0) continue;
      call.atlas.writable_tile(material, tile)[in_tile] =
          static_cast<std::uint16_t>(static_cast<std::int32_t>(amount) - quanta);
      if (quanta > 0) {
        mass += static_cast<std::uint32_t>(quanta) * weight;
        worker.picked_up[m] += std::int64_t{quanta} * weight;
      } else {
        dropped[m] = static_cast<std::uint32_t>(-quanta) * weight;
        mass -= dropped[m];
        worker.dropped[m] += dropped[m];
      }
      if (num_dirty == 0 || dirty[num_dirty - 1] != tile) dirty[num_dirty++] = tile;
    }
    if (call.maps && call.is_deposit) call.maps->record_deposit(texel, dropped);
    if (call.maps && !call.is_deposit)
      call.maps->record(texel, call.time.iteration, !piece || piece->number == 0, dropped);
  }
  return num_dirty;
}

/// Of a splat in texels: 3 and 5 are those that one and two steps of a walk reach.
double width_of(int splat_texels) { return splat_texels == 5 ? 3.0 * std::numbers::sqrt2 : splat_texels; }

}  // namespace

struct Exchanger::State {
  std::vector<Contact> ends;
  int num_materials;
  std::uint64_t seed;
  ContactSort sort;
  std::vector<Contact> by_gammaton;
  std::vector<ContactKey> keys;
  Pieces pieces;
  std::vector<TileIndex> dirty;
  std::vector<std::size_t> num_dirty;
  std::vector<Worker> workers;
};

double contact_area(const ExchangeOptions& options, const SurfaceAtlas& surface) {
  if (!(options.splat_mm > 0.0)) return 1.0;
  const double side = options.splat_mm / 3.0 / surface.median_texel_size_mm();
  return side * side;
}

Exchanger::Exchanger(int num_materials, std::uint64_t seed) : state_(std::make_unique<State>()) {
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
    if (options.rates[static_cast<std::size_t>(m)] > 0.0 && (options.contact > 0.0 || !takes_time))
      active_materials[num_active++] = m;
  }
  Call call{.seed = s.seed,
            .time = time,
            .active = std::span(active_materials).first(num_active),
            .cargo = cargo,
            .atlas = atlas,
            .maps = maps,
            .is_deposit = !endings.empty(),
            .contacts = contacts,
            .pieces = {},
            .piece_mass = {},
            .randoms = {}};
  const SurfaceAtlas& surface = atlas.surface();
  const double median_mm = surface.median_texel_size_mm();
  const double width = options.splat_mm > 0.0 ? options.splat_mm / median_mm : width_of(options.splat_texels);
  const bool is_wide = call.is_deposit || options.splat_mm > 0.0 || options.splat_texels > 1;
  const WideContacts wide{.surface = surface,
                          .contacts = contacts,
                          .endings = endings,
                          .active = call.active,
                          .seed = s.seed,
                          .random_key = time.random_key};
  if (is_wide) {
    s.pieces.cut(wide, width, cargo, s.keys, threads);
    call.pieces = s.pieces.pieces();
    call.piece_mass = s.pieces.mass();
    call.randoms = s.pieces.randoms();
  } else {
    s.keys.resize(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i)
      s.keys[i] = ContactKey{contacts[i].texel} << 32 | contacts[i].gammaton;
  }
  s.sort.cut(s.keys, surface.grid().num_texels(), threads);

  const std::int64_t num_sections = s.sort.num_sections();
  s.dirty.resize(s.keys.size());
  s.num_dirty.assign(static_cast<std::size_t>(num_sections), 0);
  const std::int64_t num_workers =
      std::clamp<std::int64_t>(thread_count(threads), 1, std::max<std::int64_t>(1, num_sections));
  if (s.workers.size() < static_cast<std::size_t>(num_workers)) s.workers.resize(static_cast<std::size_t>(num_workers));
  std::atomic<std::int64_t> next{0};
  parallel_for(num_workers, 1, threads, [&](std::int64_t w, std::int64_t) {
    Worker& worker = s.workers[static_cast<std::size_t>(w)];
    worker.table.reset(options, contact_area(options, surface), call.active);
    for (std::int64_t section = next++; section < num_sections; section = next++) {
      const std::span<const ContactKey> keys = s.sort.sort_section(section, worker.scratch);
      s.num_dirty[static_cast<std::size_t>(section)] =
          exchange_section(call, keys, worker, s.dirty.data() + s.sort.begin_of(section));
    }
  });
  if (is_wide) s.pieces.join(wide, cargo, threads);

  ExchangeReport report;
  std::size_t num_dirty = 0;
  for (std::int64_t section = 0; section < num_sections; ++section) {
    const auto from = s.dirty.begin() + static_cast<std::ptrdiff_t>(s.sort.begin_of(section));
    const std::size_t count = s.num_dirty[static_cast<std::size_t>(section)];
    std::copy_n(from, count, s.dirty.begin() + static_cast<std::ptrdiff_t>(num_dirty));
    num_dirty += count;
  }
  report.dirty_tiles = std::span<const TileIndex>(s.dirty).first(num_dirty);
  for (Worker& worker : s.workers) {
    for (std::size_t m = 0; m < kMaxMaterials; ++m) {
      report.dropped[m] += std::exchange(worker.dropped[m], 0);
      report.picked_up[m] += std::exchange(worker.picked_up[m], 0);
    }
  }
  return report;
}

}  // namespace patinate::simulation
