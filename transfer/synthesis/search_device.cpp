#include "transfer/synthesis/search_device.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "libcommon/device/device.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"

namespace patinate::transfer {

using device::Buffer;
using device::Device;
using device::DeviceError;
using device::Items;

namespace {

/// Usable pixels by control value: AlikeTables' arrays.
struct AlikeOnDevice {
  device::Buffer<std::int32_t> usable, first_with, grid_cell, grid_begin, grid_pixels;
  AlikeOnDevice(const device::Device& device, const SourceLevel& source);
};

/// The neighbors of all texels of a level: NeighborTables' arrays.
struct NeighborsOnDevice {
  device::Buffer<std::int32_t> row;
  device::Buffer<std::uint64_t> is_stored;
  device::Buffer<std::uint32_t> begin;
  device::Buffer<neighbor_kernel::PackedNeighbor> stored;
  device::Buffer<std::int32_t> triangle, steps_of;
  device::Buffer<neighbor_kernel::PackedNeighbor> steps;
  /// @throws DeviceError if the atlas has 2^31 texels or more.
  NeighborsOnDevice(const device::Device& device, const DestinationLevel& destination, const RunControl& control);
};

/// The places of all texels, which stay there from one call to the next.
class PlacesOnDevice {
 public:
  PlacesOnDevice(const device::Device& device, const TexelMap& map);
  [[nodiscard]] const device::Buffer<std::int32_t>& pixels() const { return pixels_; }
  [[nodiscard]] const device::Buffer<std::int8_t>& beside() const { return beside_; }
  [[nodiscard]] bool are_there() const { return are_there_; }
  /// Unless they are there already, as the last take() left them.
  void give(const PlaceMap& places);
  /// Reads them into room of its own, ...
  void read();
  /// ... and hands them over. In two steps, so that a device that is lost leaves what was given.
  void take(PlaceMap& places);

 private:
  device::Device device_;
  device::Buffer<std::int32_t> pixels_;
  device::Buffer<std::int8_t> beside_;
  bool are_there_ = false;
  CoordinateMap read_pixels_;
  std::vector<std::int8_t> read_beside_;
};

using device::Device;
using device::DeviceError;

AlikeOnDevice::AlikeOnDevice(const Device& device, const SourceLevel& source)
    : usable(device.upload(source.usable)),
      first_with(device.upload(source.first_with)),
      grid_cell(device.upload(source.grid_cell)),
      grid_begin(device.upload(source.grid_begin)),
      grid_pixels(device.upload(source.grid_pixels)) {}

NeighborsOnDevice::NeighborsOnDevice(const Device& device, const DestinationLevel& destination,
                                     const RunControl& control) {
  if (destination.map->num_texels() >= std::int64_t{1} << 31)
    throw DeviceError(device.info().name + ": an atlas of 2^31 texels is too large for it");
  const FlatNeighbors flat = destination.neighbors->flat(control);
  row = device.upload(flat.row);
  is_stored = device.upload(flat.is_stored);
  begin = device.upload(flat.begin);
  stored = device.upload(flat.stored);
  triangle = device.upload(destination.map->triangles());
  steps_of = device.upload(flat.steps_of);
  steps = device.upload(flat.steps);
}

PlacesOnDevice::PlacesOnDevice(const Device& device, const TexelMap& map)
    : device_(device),
      pixels_(device.allocate<std::int32_t>(static_cast<std::size_t>(map.num_texels()))),
      beside_(device.allocate<std::int8_t>(2 * static_cast<std::size_t>(map.num_texels()))) {}

void PlacesOnDevice::give(const PlaceMap& places) {
  if (are_there_) return;
  device_.write(std::span<const std::int32_t>(places.pixels), pixels_);
  device_.write(places.beside(), beside_);
}

void PlacesOnDevice::read() {
  read_pixels_.resize(pixels_.size());
  read_beside_.resize(beside_.size());
  device_.read(pixels_, std::span(read_pixels_));
  device_.read(beside_, std::span(read_beside_));
}

void PlacesOnDevice::take(PlaceMap& places) {
  std::swap(places.pixels, read_pixels_);
  std::copy(read_beside_.begin(), read_beside_.end(), places.beside().begin());
  are_there_ = true;
}

device::Program build_search_program(const Device& device, int num_neighbors) {
  const std::string size = "#define PATINATE_MOST_NEIGHBORS " + std::to_string(num_neighbors) + "\n";
  const std::array<std::string_view, 6> sources{size,        kPhiloxKernel, kNeighborKernel,
                                                kCostKernel, kSearchKernel, kSearchEntries};
  return device.build("transfer", sources);
}

int num_neighbors_of(const Neighborhood& neighborhood) {
  return static_cast<int>(neighborhood.weights.size() + TexelNeighborhood::kNumAdjacent);
}

}  // namespace

struct SearchDevice::Level::State {
  State(const SearchDevice& search_device, const SynthesisLevel& synthesis_level, const Neighborhood& neighborhood,
        const SimilarPixels& similar, const EnergyScale& scale, const RunControl& control)
      : device(search_device.device()),
        level(synthesis_level),
        program(build_search_program(device, num_neighbors_of(neighborhood))),
        list(program.kernel("list_due")),
        search(program.kernel("search_due")),
        take(program.kernel("take_due")),
        sum(program.kernel("sum_costs")),
        appearance(device.upload(level.source.appearance.values())),
        source_controls(device.upload(level.source.controls.values())),
        is_usable(device.upload(level.source.is_usable)),
        similar_pixels(device.upload(std::span(similar.data()->data(), similar.size() * kNumSimilar))),
        alike(device, level.source),
        weights(device.upload(neighborhood.weights)),
        coherence_scales(device.upload(scale.coherence_scales)),
        control_scales(device.upload(scale.control_scale)),
        targets(device.upload(level.destination.controls.values())),
        neighbors(device, level.destination, control),
        places(device, *level.destination.map) {
    const TexelMap& map = *level.destination.map;
    const auto num_texels = static_cast<std::size_t>(map.num_texels());
    changed_near = device.allocate<std::uint8_t>(num_texels);
    const std::size_t largest_set =
        static_cast<std::size_t>((map.width() + 1) / 2) * static_cast<std::size_t>((map.height() + 1) / 2);
    due = device.allocate<std::uint32_t>(largest_set);
    num_due = device.allocate<std::uint32_t>(1);
    found_pixel = device.allocate<std::int32_t>(largest_set);
    found_beside = device.allocate<std::int8_t>(2 * largest_set);
    reuse = device.allocate<std::uint8_t>(level.source.is_usable.size());
    look = device.allocate<std::uint8_t>(level.source.is_usable.size());
    excess = device.allocate<std::int32_t>(std::size_t{search_kernel::kExcessCells} * search_kernel::kExcessCells);
    const search_kernel::CostTables cost = cost_tables(neighborhood, scale);
    numbers.source_width = level.source.width();
    numbers.source_height = level.source.height();
    numbers.num_usable = alike_tables(level.source).num_usable;
    numbers.num_controls = cost.num_controls;
    numbers.num_neighbors = cost.num_neighbors;
    numbers.radius_px = cost.radius_px;
    numbers.tolerance = kSimilarTolerance;
    numbers.width = map.width();
  }

  Device device;
  const SynthesisLevel& level;
  device::Program program;
  device::Kernel list, search, take, sum;
  search_kernel::SearchNumbers numbers{};
  Buffer<std::int16_t> appearance;
  Buffer<std::uint16_t> source_controls;
  Buffer<std::uint8_t> is_usable;
  Buffer<std::int32_t> similar_pixels;
  AlikeOnDevice alike;
  Buffer<std::int16_t> weights;
  Buffer<std::int64_t> coherence_scales, control_scales;
  Buffer<std::uint16_t> targets;
  NeighborsOnDevice neighbors;
  // Buffers that passes change.
  Buffer<std::uint8_t> reuse, look;
  Buffer<std::int32_t> excess;
  PlacesOnDevice places;
  Buffer<std::uint8_t> changed_near;  ///< There as long as places are.
  std::vector<std::uint8_t> read_changed;
  // Buffers of a set: the items whose turn it is, and what was found for each.
  Buffer<std::uint32_t> due, num_due;
  Buffer<std::int32_t> found_pixel;
  Buffer<std::int8_t> found_beside;

  // Group sizes as search_device.cl has them.
  static constexpr std::uint64_t kGroup = 64, kSearchGroup = 32, kTexelsSummed = 64;

  /// Calls launch(items) for all of some texels, waiting for each: one takes some milliseconds.
  /// @param items_each  Items for each of them, in groups of `group`. @param work  Of an item; that of a search is 1.
  template <class Launch>
  void for_each_launch(std::uint64_t num_texels, std::uint64_t items_each, std::uint64_t group,
                       const RunControl& control, const Launch& launch, std::uint64_t work = 1) const {
    // Bounded in items: small cards, too, are to be done with a launch before a display notices.
    const std::uint64_t most =
        (device.info().is_gpu ? std::uint64_t{1} << 21 : std::uint64_t{1} << 17) / items_each / work;
    for (std::uint64_t first = 0; first < num_texels; first += most) {
      control.throw_if_stopped();
      const std::uint64_t num = std::min(most, num_texels - first) * items_each;
      launch(Items{.first = first * items_each, .num = (num + group - 1) / group * group, .group = group});
      device.finish();
    }
  }

  [[nodiscard]] std::uint32_t list_due(const RunControl& control) {
    device.fill_zero(num_due.memory());
    for_each_launch(numbers.num_items, 1, kGroup, control, [&](const Items& items) {
      list.run(items, numbers, neighbors.triangle, changed_near, num_due, due);
    });
    std::uint32_t num = 0;
    device.read(num_due, std::span(&num, 1));
    return num;
  }

  void run_set(const RunControl& control) {
    const TexelMap& map = *level.destination.map;
    const int rows = (map.height() - numbers.set / 2 + 1) / 2;
    numbers.columns = (map.width() - numbers.set % 2 + 1) / 2;
    numbers.num_items = static_cast<std::uint32_t>(rows) * static_cast<std::uint32_t>(numbers.columns);
    const std::uint32_t num = list_due(control);
    const NeighborsOnDevice& n = neighbors;
    for_each_launch(num, kSearchGroup, kSearchGroup, control, [&](const Items& items) {
      search.run(items, numbers, appearance, source_controls, is_usable, similar_pixels, alike.usable, alike.first_with,
                 alike.grid_cell, alike.grid_begin, alike.grid_pixels, weights, coherence_scales, control_scales, reuse,
                 look, excess, targets, n.row, n.is_stored, n.begin, n.stored, n.triangle, n.steps_of, n.steps,
                 places.pixels(), places.beside(), due, found_pixel, found_beside);
    });
    for_each_launch(num, 1, kGroup, control, [&](const Items& items) {
      take.run(items, numbers, n.row, n.is_stored, n.begin, n.stored, n.triangle, n.steps_of, n.steps, due, num,
               found_pixel, found_beside, places.pixels(), places.beside(), changed_near);
    });
  }
};

SearchDevice::Level::Level(const SearchDevice& device, const SynthesisLevel& level, const Neighborhood& neighborhood,
                           const SimilarPixels& similar, const EnergyScale& scale, const RunControl& control) {
  state_ = std::make_unique<State>(device, level, neighborhood, similar, scale, control);
}
SearchDevice::Level::~Level() = default;

void SearchDevice::Level::run(const DevicePass& pass, PlaceMap& places, std::span<std::uint8_t> changed_near,
                              const RunControl& control) {
  State& s = *state_;
  if (pass.factors.penalty != 0) s.device.write(pass.reuse, s.reuse);
  if (pass.factors.amounts != 0) {
    s.device.write(pass.looks, s.look);
    s.device.write(pass.excess, s.excess);
  }
  if (!s.places.are_there()) s.device.write(std::span<const std::uint8_t>(changed_near), s.changed_near);
  s.places.give(places);
  const search_kernel::PlaceTables tables = places.tables();
  search_kernel::SearchNumbers& numbers = s.numbers;
  numbers.reciprocal = tables.reciprocal;
  numbers.shift = tables.shift;
  numbers.seed = pass.seed;
  numbers.stream = pass.stream;
  numbers.factors = pass.factors;
  numbers.num_random = pass.num_random;
  numbers.is_whole = pass.is_whole ? 1 : 0;
  for (int set = 0; set < search_kernel::kInterleavedSets; ++set) {
    numbers.set = set;
    numbers.turn = pass.first_turn + set;
    s.run_set(control);
  }
  s.read_changed.resize(changed_near.size());
  s.places.read();
  s.device.read(s.changed_near, std::span(s.read_changed));
  s.places.take(places);
  std::copy(s.read_changed.begin(), s.read_changed.end(), changed_near.begin());
}

CostSums SearchDevice::Level::sum_costs(const EnergyScale& scale, const CoordinateMap& coordinates,
                                        const RunControl& control) {
  constexpr std::uint64_t kWork = State::kTexelsSummed / 8;  // A texel costs far less than to be searched for.
  State& s = *state_;
  const NeighborsOnDevice& n = s.neighbors;
  const auto pixels = s.device.upload(std::span<const std::int32_t>(coordinates));
  const auto coherence_scales = s.device.upload(scale.coherence_scales);
  const auto control_scales = s.device.upload(scale.control_scale);
  const std::uint64_t num_groups = (coordinates.size() + State::kTexelsSummed - 1) / State::kTexelsSummed;
  const auto sums = s.device.allocate<std::int64_t>(4 * num_groups);
  s.for_each_launch(
      num_groups, State::kSearchGroup, State::kSearchGroup, control,
      [&](const Items& items) {
        s.sum.run(items, s.numbers, s.appearance, s.source_controls, s.is_usable, s.weights, coherence_scales,
                  control_scales, s.targets, n.row, n.is_stored, n.begin, n.stored, n.triangle, n.steps_of, n.steps,
                  pixels, std::uint64_t{coordinates.size()}, sums);
      },
      kWork);
  std::vector<std::int64_t> read(4 * num_groups);
  s.device.read(sums, std::span(read));
  CostSums all;
  for (std::size_t i = 0; i < read.size(); i += 4) {
    all.coherence.high += read[i];
    all.coherence.low += read[i + 1];
    all.control.high += read[i + 2];
    all.control.low += read[i + 3];
  }
  return all;
}

}  // namespace patinate::transfer
