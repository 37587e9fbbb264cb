#include "simulation/transport/device_exchange.h"

#include <algorithm>
#include <map>
#include <vector>

#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"
#include "simulation/device/exact_sums.h"

namespace patinate::simulation {

using device::Buffer;
using device::Device;
using exchange_types::CutPart;
using exchange_types::ExchangeCall;
using exchange_types::SplatContact;
using exchange_types::SplatPiece;
using exchange_types::StencilPart;

namespace {

constexpr std::size_t kGroup = 64;
// Of one batch: launches stay short and memory small, also where all of them lie on one texel, which one item works on.
constexpr std::size_t kMostPieces = std::size_t{1} << 20;
constexpr std::size_t kMostContacts = std::size_t{1} << 14;
constexpr std::size_t kSumWords = 4 * kMaxMaterials;

static_assert(sizeof(ExchangeCall::rates) == kMaxMaterials * sizeof(double));

device::Program build(const Device& device) {
  const std::array<std::string_view, 6> sources{kPhiloxKernel,  kPortableMath, kTransferKernel,
                                                kExchangeTypes, kExactSums,    kExchangeEntries};
  return device.build("exchange", sources);
}

device::Items items_of(std::size_t num) {
  return {.num = std::max<std::size_t>(1, (num + kGroup - 1) / kGroup) * kGroup, .group = kGroup};
}

/// Contacts that are exchanged before those behind them.
struct Batch {
  std::vector<SplatContact> contacts;
  std::vector<CutPart> cut_parts;
  std::size_t num_pieces = 0;
};

/// What a part of a splat tells parameter maps.
struct Record {
  TexelIndex texel = 0;
  bool is_middle = false;
  Masses dropped{};
};

}  // namespace

struct DeviceExchange::State {
  State(const Device& its_device, const SurfaceAtlas& surface)
      : device(its_device),
        program(build(device)),
        lay(program.kernel("lay_splats")),
        hang(program.kernel("hang_pieces")),
        exchange(program.kernel("exchange_pieces")),
        join(program.kernel("join_pieces")),
        width(surface.grid().width),
        num_texels(surface.grid().num_texels()),
        weights(device.upload(surface.weights())),
        heads(device.allocate<std::uint32_t>(num_texels)) {
    const std::vector<std::uint32_t> none(num_texels, exchange_types::kNoPiece);
    device.write(std::span<const std::uint32_t>(none), heads);
  }

  /// Where a stencil's parts begin among those that the device has.
  std::uint32_t first_part(int size);
  Batch next_batch(const DeviceContacts& of, std::size_t first);
  void run(const DeviceContacts& of, const ExchangeCall& call, const Batch& batch, DeviceAmounts& amounts,
           const Cargo& cargo, bool has_maps);

  Device device;
  device::Program program;
  device::Kernel lay, hang, exchange, join;
  std::int32_t width;
  std::uint32_t num_texels;
  Buffer<std::uint16_t> weights;
  Buffer<std::uint32_t> heads;
  std::map<int, std::uint32_t> first_parts;  ///< By the size of a splat.
  std::vector<StencilPart> stencils;
  Buffer<StencilPart> stencils_there;
  std::vector<std::uint32_t> cargo_after;  ///< By contact, then active material.
  std::array<std::uint32_t, kSumWords> words{};
  std::array<std::int64_t, kMaxMaterials> picked_up{}, dropped{};  ///< By active material.
  std::vector<Record> records;
};

std::uint32_t DeviceExchange::State::first_part(int size) {
  const auto [at, is_new] = first_parts.try_emplace(size, static_cast<std::uint32_t>(stencils.size()));
  if (!is_new) return at->second;
  if (size == 0) {
    stencils.push_back({.x = 0, .y = 0, .share = SplatShape::kWhole});
  } else {
    for (const SplatStencil::Part& part : SplatShape::stencil_of(size).parts)
      stencils.push_back({.x = part.x, .y = part.y, .share = part.share});
  }
  return at->second;
}

Batch DeviceExchange::State::next_batch(const DeviceContacts& of, std::size_t first) {
  Batch batch;
  for (std::size_t i = first; i < of.contacts.size(); ++i) {
    const bool is_cut = of.cut[i] != kNotCut;
    SplatContact contact{.texel = of.contacts[i].texel,
                         .gammaton = of.contacts[i].gammaton,
                         .first_part = 0,
                         .num_parts = 1,
                         .first_piece = static_cast<std::uint32_t>(batch.num_pieces),
                         .is_cut = is_cut ? 1U : 0U};
    if (is_cut) {
      const std::size_t begin = of.cut_from[of.cut[i]], end = of.cut_from[of.cut[i] + 1];
      contact.first_part = static_cast<std::uint32_t>(batch.cut_parts.size());
      contact.num_parts = static_cast<std::uint32_t>(end - begin);
      for (std::size_t k = begin; k < end; ++k)
        batch.cut_parts.push_back({.texel = of.cut_parts[k].texel, .share = of.cut_parts[k].share});
    } else {
      const int size = of.sizes[i];
      contact.first_part = first_part(size);
      if (size > 0) contact.num_parts = static_cast<std::uint32_t>(SplatShape::stencil_of(size).parts.size());
    }
    if (batch.num_pieces > 0 && batch.num_pieces + contact.num_parts > kMostPieces) break;
    if (batch.contacts.size() == kMostContacts) break;
    batch.num_pieces += contact.num_parts;
    batch.contacts.push_back(contact);
  }
  if (stencils.size() != stencils_there.size()) stencils_there = device.upload(stencils);
  return batch;
}

void DeviceExchange::State::run(const DeviceContacts& of, const ExchangeCall& call, const Batch& batch,
                                DeviceAmounts& amounts, const Cargo& cargo, bool has_maps) {
  const std::size_t num = batch.contacts.size(), num_active = of.active.size();
  const auto n = static_cast<std::uint32_t>(num), num_pieces = static_cast<std::uint32_t>(batch.num_pieces);
  std::vector<std::uint32_t> carried;
  for (std::size_t i = 0; i < num; ++i) {
    for (const int m : of.active)
      carried.push_back(cargo.mass[batch.contacts[i].gammaton][static_cast<std::size_t>(m)]);
  }
  const CutPart nothing{};
  const auto contacts = device.upload(batch.contacts);
  const auto cut =
      device.upload(batch.cut_parts.empty() ? std::span<const CutPart>(&nothing, 1) : std::span(batch.cut_parts));
  const auto cargo_there = device.upload(carried);
  const auto randoms = device.allocate<std::uint32_t>(carried.size());
  const auto pieces = device.allocate<SplatPiece>(batch.num_pieces);
  const auto next = device.allocate<std::uint32_t>(batch.num_pieces);
  const auto masses = device.allocate<std::uint32_t>(batch.num_pieces * num_active);
  const auto moved = device.allocate<std::int32_t>(batch.num_pieces * num_active);
  words.fill(0);
  const auto sums = device.upload(std::span<const std::uint32_t>(words));
  if (stencils_there.size() == 0) stencils_there = device.allocate<StencilPart>(1);

  lay.run(items_of(num), call, n, contacts, stencils_there, cut, weights, cargo_there, randoms, pieces, masses);
  hang.run(items_of(num_pieces), num_pieces, pieces, heads, next);
  exchange.run(items_of(num_pieces), call, num_pieces, pieces, cargo_there, randoms, weights, heads, next, masses,
               moved, amounts.planes(), amounts.dirty());
  join.run(items_of(num), static_cast<std::uint32_t>(num_active), n, contacts, pieces, weights, masses, moved,
           cargo_there, sums);

  device.read(cargo_there, std::span(carried));
  cargo_after.insert(cargo_after.end(), carried.begin(), carried.end());
  device.read(sums, std::span<std::uint32_t>(words));
  const auto sum_of = [&](std::size_t at) {
    return static_cast<std::int64_t>(words[at] | std::uint64_t{words[at + 1]} << 32);
  };
  for (std::size_t a = 0; a < num_active; ++a) {
    picked_up[a] += sum_of(4 * a);
    dropped[a] += sum_of(4 * a + 2);
  }
  if (!has_maps) return;
  std::vector<SplatPiece> pieces_here(batch.num_pieces);
  std::vector<std::int32_t> moved_here(batch.num_pieces * num_active);
  device.read(pieces, std::span(pieces_here));
  device.read(moved, std::span(moved_here));
  for (std::size_t p = 0; p < pieces_here.size(); ++p) {
    if (pieces_here[p].texel == exchange_types::kNoPiece) continue;
    Record& record =
        records.emplace_back(Record{.texel = pieces_here[p].texel, .is_middle = pieces_here[p].number == 0});
    for (std::size_t a = 0; a < num_active; ++a) {
      if (moved_here[p * num_active + a] < 0)
        record.dropped[static_cast<std::size_t>(of.active[a])] =
            static_cast<std::uint32_t>(-moved_here[p * num_active + a]);
    }
  }
}

DeviceExchange::DeviceExchange(const Device& device, const SurfaceAtlas& surface)
    : state_(std::make_unique<State>(device, surface)) {}
DeviceExchange::~DeviceExchange() = default;

DeviceExchangeReport DeviceExchange::exchange(const DeviceContacts& contacts, std::int64_t iteration,
                                              DeviceAmounts& amounts, MaterialAtlas& atlas, Cargo& cargo,
                                              ParameterMaps* maps) {
  State& s = *state_;
  ExchangeCall call = contacts.call;
  call.num_active = static_cast<std::uint32_t>(contacts.active.size());
  for (std::size_t a = 0; a < contacts.active.size(); ++a)
    call.materials[a] = static_cast<std::uint32_t>(contacts.active[a]);
  call.num_texels = s.num_texels;
  call.width = s.width;
  s.cargo_after.clear();
  s.records.clear();
  s.picked_up.fill(0);
  s.dropped.fill(0);
  amounts.update(atlas);
  for (std::size_t first = 0; first < contacts.contacts.size();) {
    const Batch batch = s.next_batch(contacts, first);
    s.run(contacts, call, batch, amounts, cargo, maps != nullptr);
    first += batch.contacts.size();
  }
  DeviceExchangeReport done{.dirty_tiles = amounts.take(contacts.active, atlas)};
  const std::uint32_t* after = s.cargo_after.data();
  for (const Contact& contact : contacts.contacts) {
    for (const int m : contacts.active) cargo.mass[contact.gammaton][static_cast<std::size_t>(m)] = *after++;
  }
  for (const Record& record : s.records) {
    Masses dropped = record.dropped;
    for (std::uint32_t& mass : dropped) mass *= atlas.surface().weight(record.texel);
    if (call.is_deposit != 0) {
      maps->record_deposit(record.texel, dropped);
    } else {
      maps->record(record.texel, iteration, record.is_middle, dropped);
    }
  }
  for (std::size_t a = 0; a < contacts.active.size(); ++a) {
    done.picked_up[static_cast<std::size_t>(contacts.active[a])] = s.picked_up[a];
    done.dropped[static_cast<std::size_t>(contacts.active[a])] = s.dropped[a];
  }
  return done;
}

}  // namespace patinate::simulation
