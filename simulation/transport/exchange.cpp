#include "simulation/transport/exchange.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "libcommon/core/parallel.h"
#include "simulation/transport/contact_sort.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

namespace {

using Masses = std::array<std::uint32_t, kMaxMaterials>;

constexpr std::uint32_t kMaxMass = 0xFFFFFFFFu;
constexpr std::int64_t kSplatChunk = 256;          ///< Contacts.
constexpr std::uint32_t kDealPiece = 0x7FFFFFFFu;  ///< Random numbers for dealing out a cargo to the parts of a splat.

/// A part of a gammaton's splat, and the cargo that it has.
struct Piece {
  std::uint32_t gammaton = 0;
  std::uint32_t number = 0;  ///< In its splat; 0 = middle.
  std::uint32_t num_parts = 1;
  std::uint32_t share = Splat::kWhole;
  Masses mass{};
};

/// transfer_shares() of the weights and shares that turn up: a few hundred of them serve a million contacts.
class ShareTable {
 public:
  void reset(const ExchangeOptions& options, std::span<const int> active) {
    const bool is_same = !keys_.empty() && options.ratio == options_.ratio && options.contact == options_.contact &&
                         options.rates == options_.rates;
    if (is_same && std::equal(active.begin(), active.end(), active_.begin(), active_.end())) return;
    options_ = options;
    active_.assign(active.begin(), active.end());
    keys_.assign(kSize, 0);
    shares_.resize(kSize * active.size());
  }
  /// By active material.
  [[nodiscard]] const TransferShares* find(std::uint32_t weight, std::uint32_t share) {
    const std::uint64_t key = std::uint64_t{weight} << 16 | share;
    const std::size_t slot = (weight + share * 97u) % kSize;
    TransferShares* found = shares_.data() + slot * active_.size();
    if (keys_[slot] != key) {
      keys_[slot] = key;
      for (std::size_t a = 0; a < active_.size(); ++a) {
        found[a] = transfer_shares(options_.ratio, options_.rates[static_cast<std::size_t>(active_[a])],
                                   options_.contact, weight, static_cast<double>(share) / Splat::kWhole);
      }
    }
    return found;
  }

 private:
  static constexpr std::size_t kSize = 1024;
  ExchangeOptions options_;
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
  std::span<Piece> pieces;  ///< By the keys' carrier; empty when carriers are gammatons.
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

[[nodiscard]] Masses& mass_of(const Call& call, std::uint32_t carrier) {
  return call.pieces.empty() ? call.cargo.mass[carrier] : call.pieces[carrier].mass;
}

void prepare(const Call& call, std::span<const ContactKey> keys, Batch& batch) {
  const SurfaceAtlas& surface = call.atlas.surface();
  const auto texel = [&](std::size_t i) { return static_cast<TexelIndex>(keys[i] >> 32); };
  for (std::size_t i = 0; i < keys.size(); ++i) {
    __builtin_prefetch(&mass_of(call, static_cast<std::uint32_t>(keys[i])), 1);
    batch.weight[i] = surface.weight(texel(i));
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    for (std::size_t a = 0; a < call.active.size(); ++a) {
      batch.stored[i][a] = call.atlas.tile(call.active[a], TileGrid::tile_of(texel(i))).data();
      if (batch.stored[i][a]) __builtin_prefetch(batch.stored[i][a] + texel(i) % TileGrid::kTileTexels, 1);
    }
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto carrier = static_cast<std::uint32_t>(keys[i]);
    const bool is_whole = call.pieces.empty();
    batch.randoms[i] =
        transfer_randoms(call.seed, is_whole ? carrier : call.pieces[carrier].gammaton, call.time.random_key,
                         is_whole ? 0 : call.pieces[carrier].number, static_cast<int>(call.active.size()));
  }
}

/// What a gammaton, or a piece of one, may hold: all pieces together no more than their gammaton may.
[[nodiscard]] std::uint32_t limit_of(const Call& call, const Piece* piece, std::size_t material) {
  return piece ? piece->mass[material] + (kMaxMass - call.cargo.mass[piece->gammaton][material]) / piece->num_parts
               : kMaxMass;
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
    Masses& mass = mass_of(call, carrier);
    const std::uint32_t weight = batch.weight[b];
    const TransferShares* shares = worker.table.find(weight, piece ? piece->share : Splat::kWhole);
    const std::size_t in_tile = texel % TileGrid::kTileTexels;
    Masses dropped{};
    for (std::size_t a = 0; a < call.active.size(); ++a) {
      const int material = call.active[a];
      const auto m = static_cast<std::size_t>(material);
      // A page that was not there may have been made since.
      const std::uint16_t* stored = batch.stored[b][a] ? batch.stored[b][a] : call.atlas.tile(material, tile).data();
      const std::uint32_t amount = stored ? stored[in_tile] : call.atlas.original(material, texel);
      const std::int32_t quanta =
          transfer_quanta(shares[a], amount, weight, mass[m], batch.randoms[b][a], limit_of(call, piece, m));
      if (quanta == 0) continue;
      call.atlas.writable_tile(material, tile)[in_tile] =
          static_cast<std::uint16_t>(static_cast<std::int32_t>(amount) - quanta);
      if (quanta > 0) {
        mass[m] += static_cast<std::uint32_t>(quanta) * weight;
        worker.picked_up[m] += std::int64_t{quanta} * weight;
      } else {
        dropped[m] = static_cast<std::uint32_t>(-quanta) * weight;
        mass[m] -= dropped[m];
        worker.dropped[m] += dropped[m];
      }
      if (num_dirty == 0 || dirty[num_dirty - 1] != tile) dirty[num_dirty++] = tile;
    }
    if (call.maps) call.maps->record(texel, call.time.iteration, !piece || piece->number == 0, dropped);
  }
  return num_dirty;
}

/// Deals a gammaton's cargo out to its pieces: whole quanta of its middle texel, as many to each as its share says in
/// the mean, and what is less than one to the middle. Amounts that are less than a quantum for every part still find
/// their way that way.
void deal(const Call& call, std::uint32_t gammaton, std::uint32_t middle_weight, std::span<Piece> pieces) {
  const Masses randoms =
      transfer_randoms(call.seed, gammaton, call.time.random_key, kDealPiece, static_cast<int>(call.active.size()));
  for (std::size_t a = 0; a < call.active.size(); ++a) {
    const auto m = static_cast<std::size_t>(call.active[a]);
    const std::uint64_t quanta = call.cargo.mass[gammaton][m] / middle_weight;
    const std::uint64_t start = randoms[a] % Splat::kWhole;
    std::uint64_t share = 0, dealt = 0;
    for (Piece& piece : pieces) {
      share += piece.share;
      const std::uint64_t until = (quanta * share + start) / Splat::kWhole;
      piece.mass[m] = static_cast<std::uint32_t>((until - dealt) * middle_weight);
      dealt = until;
    }
    pieces[0].mass[m] += call.cargo.mass[gammaton][m] % middle_weight;
  }
}

}  // namespace

struct Exchanger::State {
  int num_materials;
  std::uint64_t seed;
  ContactSort sort;
  std::vector<Contact> by_gammaton;
  std::vector<ContactKey> keys;
  std::vector<Splat> splats;
  std::vector<std::size_t> first_piece;
  std::vector<Piece> pieces;
  std::vector<TileIndex> dirty;
  std::vector<std::size_t> num_dirty;
  std::vector<Worker> workers;

  void cut_splats(std::span<const Contact> contacts, int width, const Call& call, const RunControl& control);
  void join_pieces(std::span<const Contact> contacts, const Call& call, const RunControl& control);
};

/// Fills pieces (cargo included) and keys.
void Exchanger::State::cut_splats(std::span<const Contact> contacts, int width, const Call& call,
                                  const RunControl& control) {
  const auto n = static_cast<std::int64_t>(contacts.size());
  const SurfaceAtlas& surface = call.atlas.surface();
  splats.resize(contacts.size());
  first_piece.resize(contacts.size() + 1);
  parallel_for(n, kSplatChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      splats[i] = splat_of(surface, contacts[i].texel, width);
  });
  std::size_t sum = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    first_piece[i] = sum;
    sum += static_cast<std::size_t>(splats[i].num_parts);
  }
  first_piece.back() = sum;
  pieces.resize(sum);
  keys.resize(sum);
  parallel_for(n, kSplatChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const auto num_parts = static_cast<std::uint32_t>(splats[i].num_parts);
      for (std::uint32_t k = 0; k < num_parts; ++k) {
        const SplatPart& part = splats[i].parts[k];
        pieces[first_piece[i] + k] = {
            .gammaton = contacts[i].gammaton, .number = k, .num_parts = num_parts, .share = part.share, .mass = {}};
        keys[first_piece[i] + k] = ContactKey{part.texel} << 32 | (first_piece[i] + k);
      }
      deal(call, contacts[i].gammaton, surface.weight(contacts[i].texel),
           std::span(pieces).subspan(first_piece[i], num_parts));
    }
  });
}

/// Sums the pieces' cargo up again.
void Exchanger::State::join_pieces(std::span<const Contact> contacts, const Call& call, const RunControl& control) {
  parallel_for(static_cast<std::int64_t>(contacts.size()), kSplatChunk, control,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                   for (const int material : call.active) {
                     const auto m = static_cast<std::size_t>(material);
                     std::uint32_t sum = 0;
                     for (std::size_t p = first_piece[i]; p < first_piece[i + 1]; ++p) sum += pieces[p].mass[m];
                     call.cargo.mass[contacts[i].gammaton][m] = sum;
                   }
                 }
               });
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
    if (options.rates[static_cast<std::size_t>(m)] > 0.0 && options.contact > 0.0) active_materials[num_active++] = m;
  }
  Call call{.seed = s.seed,
            .time = time,
            .active = std::span(active_materials).first(num_active),
            .cargo = cargo,
            .atlas = atlas,
            .maps = maps,
            .pieces = {}};
  if (options.splat_texels > 1) {
    s.cut_splats(contacts, options.splat_texels, call, threads);
    call.pieces = s.pieces;
  } else {
    s.keys.resize(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i)
      s.keys[i] = ContactKey{contacts[i].texel} << 32 | contacts[i].gammaton;
  }
  s.sort.cut(s.keys, atlas.surface().grid().num_texels(), threads);

  const std::int64_t num_sections = s.sort.num_sections();
  s.dirty.resize(s.keys.size());
  s.num_dirty.assign(static_cast<std::size_t>(num_sections), 0);
  const std::int64_t num_workers =
      std::clamp<std::int64_t>(thread_count(threads), 1, std::max<std::int64_t>(1, num_sections));
  if (s.workers.size() < static_cast<std::size_t>(num_workers)) s.workers.resize(static_cast<std::size_t>(num_workers));
  std::atomic<std::int64_t> next{0};
  parallel_for(num_workers, 1, threads, [&](std::int64_t w, std::int64_t) {
    Worker& worker = s.workers[static_cast<std::size_t>(w)];
    worker.table.reset(options, call.active);
    for (std::int64_t section = next++; section < num_sections; section = next++) {
      const std::span<const ContactKey> keys = s.sort.sort_section(section, worker.scratch);
      s.num_dirty[static_cast<std::size_t>(section)] =
          exchange_section(call, keys, worker, s.dirty.data() + s.sort.begin_of(section));
    }
  });
  if (options.splat_texels > 1) s.join_pieces(contacts, call, threads);

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
