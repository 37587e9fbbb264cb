#include "simulation/transport/device_exchange.h"

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"
#include "simulation/transport/pieces.h"
#include "simulation/transport/splat.h"

namespace patinate::simulation {

using device::Buffer;
using device::Device;
using exchange_types::ExchangeCall;
using exchange_types::SplatPiece;
using exchange_types::StencilFacts;
using exchange_types::StencilPart;
using exchange_types::SurfaceLink;
using exchange_types::TrailPlace;
using exchange_types::Walk;
using exchange_types::WalkRoom;

namespace {

constexpr std::size_t kLayItems = 32, kWalkItems = 128, kTrailItems = 128,
                      kGroup = 64;                    // Group sizes as the kernels have them.
constexpr std::size_t kBatch = std::size_t{1} << 16;  // Gammatons of one launch, which stays short.
constexpr std::uint32_t kFirstSlots = 256;            // Tiles that a trail touches.
constexpr std::size_t kMinPieces = std::size_t{1} << 16, kMinWalked = std::size_t{1} << 18;

static_assert(sizeof(ExchangeCall::rates) == kMaxMaterials * sizeof(double));
static_assert(sizeof(SurfaceLink) == sizeof(SurfaceAtlas::Link));
static_assert(sizeof(Trail) == 17 * sizeof(std::uint32_t));

device::Program build(const Device& device) {
  const std::array<std::string_view, 12> sources{kPhiloxKernel, kPortableMath, kTransferKernel, kSpreadKernel,
                                                 kTallyTypes,   kTallyKernel,  kExchangeTypes,  kSplatsThere,
                                                 kWalksThere,   kLayEntries,   kTrailEntries,   kExchangeEntries};
  return device.build("exchange", sources);
}

/// Stencils by size.
struct Stencils {
  std::vector<StencilFacts> facts;
  std::vector<StencilPart> parts;

  void add(int size) {
    StencilFacts& of = facts[size];
    if (size == 0 || of.num > 0) return;
    const SplatStencil& stencil = SplatShape::stencil_of(size);
    of = {.first = static_cast<std::uint32_t>(parts.size()),
          .num = static_cast<std::uint32_t>(stencil.parts.size()),
          .reach = stencil.reach};
    for (const SplatStencil::Part& part : stencil.parts)
      parts.push_back({.x = part.x, .y = part.y, .share = part.share});
  }
};

}  // namespace

struct DeviceExchange::State {
  State(const DeviceArrays& arrays, const SurfaceAtlas& its_surface, const ParameterMapChoice& its_choice);

  void allocate_pieces(std::size_t num);
  void allocate_slots(std::uint32_t num);
  void allocate_walks(std::size_t num_walks, std::size_t num_parts);
  void walk(const DeviceArrays& arrays);
  /// Those of a phase are laid: exchanges them.
  void run(DeviceArrays& arrays, std::uint32_t phase);
  void begin(ExchangeTime time, std::uint32_t phase);

  Device device;
  const SurfaceAtlas* surface;
  ParameterMapChoice choice;
  device::Program program;
  device::Kernel lay_contacts, walk_splats, lay_cut, find_places, lay_endings;
  std::array<device::Kernel, 3> exchange;  ///< By phase: their arguments differ.
  std::size_t num_gammatons, num_groups;
  Buffer<std::uint16_t> triangle_weights;
  Buffer<std::uint8_t> is_plain;
  Buffer<std::uint32_t> linked, first_linked, first_link;
  Buffer<SurfaceLink> links;
  Buffer<StencilFacts> stencils;
  Buffer<StencilPart> stencil_parts;
  Buffer<std::uint32_t> wholes, randoms, masses, heads, next, cut, link_to, slots, part_texel, part_share, num_places;
  Buffer<double> link_flow;
  Buffer<SplatPiece> pieces;
  Buffer<WalkRoom> rooms;
  Buffer<Walk> walks;
  Buffer<TrailPlace> places;
  Buffer<std::uint32_t> hits, last, residence;
  Buffer<std::uint64_t> deposited;
  ExchangeCall call{};                                ///< Call for contacts.
  std::array<std::uint32_t, kMaxMaterials> active{};  ///< Materials with a rate, for deposits.
  std::uint32_t num_active = 0;
  bool is_deposited = false;
  SplatWidths widths;
};

DeviceExchange::State::State(const DeviceArrays& arrays, const SurfaceAtlas& its_surface,
                             const ParameterMapChoice& its_choice)
    : device(arrays.device),
      surface(&its_surface),
      choice(its_choice),
      program(build(device)),
      lay_contacts(program.kernel("lay_contacts")),
      walk_splats(program.kernel("walk_splats")),
      lay_cut(program.kernel("lay_cut")),
      find_places(program.kernel("find_places")),
      lay_endings(program.kernel("lay_endings")),
      exchange{program.kernel("exchange_pieces"), program.kernel("exchange_pieces"), program.kernel("exchange_pieces")},
      num_gammatons(arrays.num_gammatons),
      num_groups(4 * static_cast<std::size_t>(std::max(1, device.info().num_units))),
      triangle_weights(device.upload(surface->triangle_weights())),
      is_plain(device.upload(surface->plain_tiles())),
      linked(upload_some(device, surface->linked())),
      first_linked(device.upload(surface->first_linked())),
      first_link(upload_some(device, surface->first_links())),
      links(upload_some(device,
                        std::span<const SurfaceLink>(reinterpret_cast<const SurfaceLink*>(surface->all_links().data()),
                                                     surface->all_links().size()))),
      wholes(device.allocate<std::uint32_t>(num_gammatons * arrays.num_materials)),
      randoms(device.allocate<std::uint32_t>(num_gammatons * arrays.num_materials)),
      heads(device.allocate<std::uint32_t>(arrays.num_texels)),
      num_places(device.allocate<std::uint32_t>(num_gammatons)),
      rooms(device.allocate<WalkRoom>(num_groups)),
      places(device.allocate<TrailPlace>(Trail::kLength * num_gammatons)) {
  const std::size_t texels = arrays.num_texels;
  hits = device.allocate<std::uint32_t>(choice.hits ? texels : 1);
  last = device.allocate<std::uint32_t>(choice.last_hit || choice.residence ? texels : 1);
  residence = device.allocate<std::uint32_t>(choice.residence ? texels : 1);
  if (choice.hits) call.maps |= exchange_types::kMapHits;
  if (choice.last_hit || choice.residence) call.maps |= exchange_types::kMapLast;
  if (choice.residence) call.maps |= exchange_types::kMapResidence;
  std::uint32_t num_deposited = 0;
  for (std::size_t m = 0; m < kMaxMaterials; ++m) call.map_of[m] = choice.deposited[m] ? ++num_deposited : 0;
  deposited = device.allocate<std::uint64_t>(std::max<std::size_t>(1, num_deposited * texels));
  std::uint32_t most_links = 4;
  const std::span<const std::uint32_t> first = surface->first_links();
  for (std::size_t i = 0; i + 1 < first.size(); ++i) most_links = std::max(most_links, first[i + 1] - first[i]);
  if (kWalkItems * most_links + transfer_kernel::kWalkTexels > 2048)  // Limit of walk_device.cl.
    throw device::DeviceError(device.info().name + ": texels of this surface have up to " + std::to_string(most_links) +
                              " neighbors, which is too many for it");
  call.most_links = most_links;
  link_to = device.allocate<std::uint32_t>(num_groups * kWalkItems * most_links);
  link_flow = device.allocate<double>(num_groups * kWalkItems * most_links);
  call.num_materials = arrays.num_materials;
  call.num_texels = arrays.num_texels;
  call.atlas_width = arrays.width;
  allocate_slots(kFirstSlots);
  allocate_walks(num_gammatons + 1024, kMinWalked);
  device.fill_words(heads.memory(), exchange_types::kNoPiece);
}

void DeviceExchange::State::allocate_pieces(std::size_t num) {
  num = std::min<std::size_t>(num, exchange_types::kNoPiece - 1);
  pieces = device.allocate<SplatPiece>(num);
  next = device.allocate<std::uint32_t>(num);
  masses = device.allocate<std::uint32_t>(num * std::max(1U, num_active));
  call.most_pieces = static_cast<std::uint32_t>(num);
}

void DeviceExchange::State::allocate_slots(std::uint32_t num) {
  call.num_slots = num;
  slots = device.allocate<std::uint32_t>(num_groups * num * 71);  // Slots as lay_endings() has them.
  device.fill_zero(slots.memory());
}

void DeviceExchange::State::allocate_walks(std::size_t num_walks, std::size_t num_parts) {
  walks = device.allocate<Walk>(num_walks);
  cut = device.allocate<std::uint32_t>(num_walks);
  part_texel = device.allocate<std::uint32_t>(num_parts);
  part_share = device.allocate<std::uint32_t>(num_parts);
  call.most_walks = static_cast<std::uint32_t>(num_walks);
  call.most_walked = static_cast<std::uint32_t>(num_parts);
}

DeviceExchange::DeviceExchange(const DeviceArrays& arrays, const SurfaceAtlas& surface,
                               const ParameterMapChoice& choice)
    : state_(std::make_unique<State>(arrays, surface, choice)) {}
DeviceExchange::~DeviceExchange() = default;

void DeviceExchange::set(const ExchangeOptions& options, const SplatWidths& widths, double contact_area,
                         std::uint64_t seed) {
  State& s = *state_;
  ExchangeCall& call = s.call;
  call.seed = seed;
  call.ratio = options.ratio;
  call.contact = options.contact;
  call.contact_area = contact_area;
  const std::uint32_t before = s.num_active;
  s.num_active = 0;
  for (std::uint32_t m = 0; m < call.num_materials; ++m) {
    if (!(options.rates[m] > 0.0)) continue;
    s.active[s.num_active] = m;
    call.rates[s.num_active++] = options.rates[m];
  }
  std::copy(s.active.begin(), s.active.end(), call.materials);
  s.is_deposited = options.deposit && s.num_active > 0;
  if (widths.contact != s.widths.contact || widths.deposit != s.widths.deposit || s.stencils.size() == 0) {
    Stencils found{.facts = std::vector<StencilFacts>(transfer_kernel::kMaxVariance + 1, StencilFacts{}), .parts = {}};
    const std::span<const std::uint16_t> weights = s.surface->triangle_weights();
    const std::set<std::uint16_t> distinct(weights.begin(), weights.end());
    for (std::uint32_t length = 0; length <= Trail::kLength; ++length) {
      const double wide = length == 0 ? widths.contact : widths.deposit * transfer_kernel::stain_width(length);
      for (const std::uint16_t weight : distinct) found.add(transfer_kernel::splat_variance(wide, weight));
    }
    s.stencils = s.device.upload(found.facts);
    s.stencil_parts = upload_some(s.device, std::span<const StencilPart>(found.parts));
    s.widths = widths;
  } else if (before == s.num_active && s.pieces.size() > 0) {
    return;
  }
  const int size = transfer_kernel::splat_variance(widths.contact, SurfaceAtlas::kMedianWeight);
  const std::size_t each = size == 0 ? 1 : SplatShape::stencil_of(size).parts.size();
  s.allocate_pieces(std::max<std::size_t>({s.pieces.size(), kMinPieces, s.num_gammatons * each * 3 / 2}));
}

bool DeviceExchange::deposits() const { return state_->is_deposited; }

void DeviceExchange::State::begin(ExchangeTime time, std::uint32_t phase) {
  const bool is_deposit = phase != tally_types::kPhaseOfContacts;
  call.random_key = static_cast<std::uint64_t>(time.random_key);
  call.iteration = static_cast<std::int32_t>(time.iteration);
  call.phase = phase;
  call.random_piece = is_deposit ? kDepositPiece : 0;
  call.width = is_deposit ? widths.deposit : widths.contact;
  call.num_active = is_deposit || call.contact > 0.0 ? num_active : 0;
}

void DeviceExchange::State::walk(const DeviceArrays& a) {
  walk_splats.run({.num = num_groups * kWalkItems, .group = kWalkItems}, call, a.weights, a.triangles, triangle_weights,
                  is_plain, linked, first_linked, first_link, links, stencils, stencil_parts, walks, rooms, link_to,
                  link_flow, part_texel, part_share, a.tally);
}

void DeviceExchange::State::run(DeviceArrays& a, std::uint32_t phase) {
  // Items take pieces in turns: how many there are only the device knows.
  const std::size_t num =
      std::min<std::size_t>((call.most_pieces + kGroup - 1) / kGroup * kGroup, num_groups * 8 * kGroup);
  exchange[phase].run({.num = num, .group = kGroup}, call, pieces, a.weights, wholes, randoms, heads, next, masses,
                      a.cargo, a.amounts, a.dirty, a.changed_in, a.awake, a.is_listed, a.touched, hits, last, residence,
                      deposited, a.tally);
}

void DeviceExchange::exchange(DeviceArrays& a, ExchangeTime time) {
  State& s = *state_;
  s.begin(time, tally_types::kPhaseOfContacts);
  if (s.call.num_active == 0 && s.call.maps == 0) return;
  for (std::size_t first = 0; first < s.num_gammatons; first += kBatch) {
    s.lay_contacts.run(
        {.first = first * kLayItems, .num = std::min(kBatch, s.num_gammatons - first) * kLayItems, .group = kLayItems},
        s.call, a.weights, a.triangles, s.triangle_weights, s.is_plain, s.linked, s.first_linked, s.first_link, s.links,
        s.stencils, s.stencil_parts, a.contacts, a.cargo, s.wholes, s.randoms, s.pieces, s.masses, s.heads, s.next,
        a.tally, s.walks, s.cut);
  }
  if (s.call.width > 0.0) {
    s.walk(a);
    s.lay_cut.run({.num = s.num_groups * kLayItems, .group = kLayItems}, s.call, a.weights, a.cargo, s.wholes,
                  s.randoms, s.pieces, s.masses, s.heads, s.next, a.tally, s.walks, s.part_texel, s.part_share, s.cut);
  }
  s.run(a, tally_types::kPhaseOfContacts);
}

void DeviceExchange::deposit(DeviceArrays& a, ExchangeTime time, std::uint32_t which) {
  State& s = *state_;
  if (!s.is_deposited) return;
  const std::uint32_t phase = which == 0 ? tally_types::kPhaseOfWays : tally_types::kPhaseOfResponses;
  s.begin(time, phase);
  const std::size_t num_items =
      std::min<std::size_t>((Trail::kLength * s.num_gammatons + kGroup - 1) / kGroup, 8 * s.num_groups) * kGroup;
  s.find_places.run({.num = num_items, .group = kGroup}, s.call, a.weights, a.triangles, s.triangle_weights, s.is_plain,
                    s.linked, s.first_linked, s.first_link, s.links, s.stencils, s.stencil_parts, a.trails,
                    a.endings[which], which, s.places, s.num_places, s.walks, a.tally);
  s.walk(a);
  s.lay_endings.run({.num = s.num_groups * kTrailItems, .group = kTrailItems}, s.call, a.weights, a.triangles,
                    s.triangle_weights, s.is_plain, s.linked, s.first_linked, s.first_link, s.links, s.stencils,
                    s.stencil_parts, a.trails, a.endings[which], which, a.cargo, s.wholes, s.randoms, s.pieces,
                    s.masses, s.heads, s.next, a.tally, s.places, s.num_places, s.walks, s.part_texel, s.part_share,
                    s.slots);
  s.run(a, phase);
}

void DeviceExchange::grow(std::uint32_t overflown) {
  State& s = *state_;
  if ((overflown & 1) != 0) s.allocate_pieces(2 * s.pieces.size());
  s.allocate_slots((overflown & 2) != 0 ? 2 * s.call.num_slots : s.call.num_slots);
  if ((overflown & 4) != 0) s.allocate_walks(2 * s.walks.size(), 4 * s.part_texel.size());
  s.device.fill_words(s.heads.memory(), exchange_types::kNoPiece);
}

namespace {

/// f(values, first, buffer) for each map that is kept: `first` is where its values begin in the buffer.
template <class Maps, class State, class F>
void for_each_map(Maps& maps, State& s, const ParameterMapChoice& choice, F&& f) {
  if (choice.hits) f(*maps.hits(), 0, s.hits);
  if (choice.last_hit || choice.residence) f(*maps.last_hit(), 0, s.last);
  if (choice.residence) f(*maps.residence(), 0, s.residence);
  for (int m = 0; m < kMaxMaterials; ++m) {
    if (auto* values = maps.deposited(m)) f(*values, s.call.map_of[m] - 1, s.deposited);
  }
}

}  // namespace

void DeviceExchange::put_maps(const ParameterMaps& maps) {
  State& s = *state_;
  const std::size_t num = s.call.num_texels;
  for_each_map(maps, s, s.choice, [&]<class T>(const PagedValues<T>& values, std::size_t plane, Buffer<T>& buffer) {
    std::vector<T> all(num);
    for (std::uint32_t p = 0; p < values.num_pages(); ++p) {
      const std::span<const T> page = values.page(p);
      std::copy(page.begin(), page.end(), all.begin() + static_cast<std::ptrdiff_t>(p * page.size()));
    }
    s.device.write(std::span<const T>(all), buffer, plane * num);
  });
}

std::vector<std::function<void()>> DeviceExchange::read_maps(ParameterMaps& maps) const {
  const State& s = *state_;
  const std::size_t num = s.call.num_texels;
  std::vector<std::function<void()>> changes;
  const void* last_read = nullptr;
  std::shared_ptr<void> last_values;  // Deposited mass of all materials is one buffer.
  for_each_map(maps, s, s.choice, [&]<class T>(PagedValues<T>& values, std::size_t plane, const Buffer<T>& buffer) {
    if (last_read != &buffer) {
      auto all = std::make_shared<std::vector<T>>(buffer.size());
      s.device.read(buffer, std::span(*all));
      last_values = all;
      last_read = &buffer;
    }
    const auto all = std::static_pointer_cast<std::vector<T>>(last_values);
    for (std::uint32_t p = 0; p < values.num_pages(); ++p) {
      const std::span<const T> page =
          std::span<const T>(*all).subspan(plane * num + std::size_t{p} * TileGrid::kPageTexels, TileGrid::kPageTexels);
      if (std::all_of(page.begin(), page.end(), [](T value) { return value == 0; })) continue;
      // The page is made here, where that may fail; one of nothing but 0 says nothing.
      changes.emplace_back(
          [to = values.writable_page(p), page, all] { std::copy(page.begin(), page.end(), to.begin()); });
    }
  });
  return changes;
}

}  // namespace patinate::simulation
