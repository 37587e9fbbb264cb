#include "transfer/synthesis/window_device.h"

#include <algorithm>
#include <array>
#include <string>

#include "libcommon/core/parallel.h"
#include "transfer/synthesis/device_tables.h"
#include "transfer/synthesis/neighborhood_projection.h"
#include "transfer/synthesis/window_kernel.h"

namespace patinate::transfer {

using device::Buffer;
using device::Device;
using device::Items;

namespace {

/// Items that share a texel: as many as keep a unit of a GPU busy, since fronts are narrow; drivers of CPUs take one
/// after the other, and keep what all have on a stack.
std::uint64_t items_a_texel(const Device& device) { return device.info().is_gpu ? 256 : 64; }

device::Program build_window_program(const Device& device, const Neighborhood& neighborhood) {
  const std::string sizes = "#define PATINATE_MOST_NEIGHBORS " +
                            std::to_string(neighborhood.weights.size() + TexelNeighborhood::kNumAdjacent) +
                            "\n#define PATINATE_WINDOW_ITEMS " + std::to_string(items_a_texel(device)) + "\n";
  const std::array<std::string_view, 8> sources{sizes,         kPhiloxKernel, kNeighborKernel, kCostKernel,
                                                kSearchKernel, kWindowKernel, kWindowGroup,    kWindowEntries};
  return device.build("exact search", sources);
}

std::vector<std::int16_t> offsets_of(const Neighborhood& neighborhood) {
  std::vector<std::int16_t> offsets;
  for (const Offset& o : neighborhood.offsets)
    offsets.insert(offsets.end(), {static_cast<std::int16_t>(o.x), static_cast<std::int16_t>(o.y)});
  return offsets;
}

std::vector<std::uint8_t> quarters_of(const Neighborhood& neighborhood) {
  std::vector<std::uint8_t> quarters;
  for (const Offset& o : neighborhood.offsets) quarters.push_back(static_cast<std::uint8_t>(quarter_of(o)));
  return quarters;
}

/// By pixel.
std::vector<std::uint16_t> first_controls_of(const SourceLevel& source) {
  std::vector<std::uint16_t> values(source.is_usable.size(), window_kernel::kNotUsable);
  for (const std::int32_t p : source.usable)
    values[static_cast<std::size_t>(p)] = source.controls.data()[std::int64_t{p} * source.controls.channels()];
  return values;
}

/// By pixel, of usable ones.
std::vector<std::int16_t> projections_of(const SourceLevel& source, const NeighborhoodProjection& projection,
                                         const RunControl& control) {
  constexpr std::size_t kValues = window_kernel::kProjectedValues;
  std::vector<std::int16_t> values(source.is_usable.size() * kValues);
  parallel_for(
      static_cast<std::int64_t>(source.usable.size()), 4096, control, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const ProjectedNeighborhood p = projection.of_pixel(source.usable[i]);
          std::copy(p.begin(), p.end(), values.begin() + std::int64_t{source.usable[i]} * std::int64_t{kValues});
        }
      });
  return values;
}

/// By value of a list of appearances, so that items that sum up for one value each read beside one another.
std::vector<std::int16_t> rows_of(const NeighborhoodProjection& projection) {
  constexpr std::size_t kValues = window_kernel::kProjectedValues;
  const std::span<const std::int16_t> rows = projection.rows();
  const std::size_t size = rows.size() / kValues;
  std::vector<std::int16_t> turned(rows.size());
  for (std::size_t j = 0; j < kValues; ++j) {
    for (std::size_t i = 0; i < size; ++i) turned[i * kValues + j] = rows[j * size + i];
  }
  return turned;
}

/// What all searches of a source read, and how launches are paced.
struct SourceOnDevice {
  Device device;
  device::Program program;
  Buffer<std::int16_t> appearance;
  Buffer<std::uint16_t> controls;
  Buffer<std::uint8_t> is_usable;
  Buffer<std::int16_t> weights;
  Buffer<std::int64_t> coherence_scales, control_scales;
  Buffer<std::int16_t> offsets;
  Buffer<std::uint8_t> quarters;
  Buffer<std::uint16_t> first_controls;
  std::array<Buffer<std::int16_t>, 2> projections, rows;  ///< Whole, by quarters.
  window_kernel::WindowNumbers numbers{};
  std::int64_t pixels_queued = 0;  ///< Of windows that were not waited for.

  SourceOnDevice(const Device& opened, const SourceLevel& source, const Neighborhood& neighborhood, int num_controls,
                 const RunControl& control)
      : device(opened),
        program(build_window_program(device, neighborhood)),
        appearance(device.upload(source.appearance.values())),
        controls(device.upload(source.controls.values())),
        is_usable(device.upload(source.is_usable)),
        weights(device.upload(neighborhood.weights)),
        coherence_scales(device.allocate<std::int64_t>(Neighborhood::kLargestSum + 1)),
        control_scales(device.allocate<std::int64_t>(static_cast<std::size_t>(num_controls))),
        offsets(device.upload(offsets_of(neighborhood))),
        quarters(device.upload(quarters_of(neighborhood))),
        first_controls(device.upload(first_controls_of(source))) {
    for (const auto parts : {NeighborhoodProjection::Parts::Whole, NeighborhoodProjection::Parts::Quarters}) {
      const NeighborhoodProjection projection(source, neighborhood, parts);
      const std::size_t i = parts == NeighborhoodProjection::Parts::Whole ? 0 : 1;
      projections[i] = device.upload(projections_of(source, projection, control));
      rows[i] = device.upload(rows_of(projection));
    }
    numbers.source_width = source.width();
    numbers.source_height = source.height();
    numbers.num_usable = static_cast<std::int32_t>(source.usable.size());
    numbers.num_controls = num_controls;
    numbers.num_neighbors = static_cast<std::int32_t>(neighborhood.weights.size());
    numbers.radius_px = neighborhood.radius_px;
  }

  void set(const EnergyScale& scale) {
    device.write(std::span(scale.coherence_scales), coherence_scales);
    device.write(std::span(scale.control_scale), control_scales);
  }

  /// Queues kernel(numbers, tables of this, args...) for `num` texels from the `first` of a list, each with a window of
  /// `window` pixels, and waits now and then: for some milliseconds.
  template <class... Args>
  void run(device::Kernel& kernel, std::size_t first, std::size_t num, std::int64_t window, const RunControl& control,
           const Args&... args) {
    // Where nothing can be ruled out, all pixels are compared: 10^9 a second on the smallest of GPUs.
    const std::int64_t most = std::int64_t{1} << (device.info().is_gpu ? 26 : 20);
    const std::size_t most_texels = static_cast<std::size_t>(std::max<std::int64_t>(1, most / window));
    for (std::size_t begin = 0; begin < num; begin += most_texels) {
      const std::size_t some = std::min(most_texels, num - begin);
      numbers.first = static_cast<std::uint32_t>(first + begin);
      const std::uint64_t group = items_a_texel(device);
      kernel.run(Items{.first = 0, .num = some * group, .group = group}, numbers, appearance, controls, is_usable,
                 weights, coherence_scales, control_scales, offsets, quarters, first_controls, projections[0],
                 projections[1], rows[0], rows[1], args...);
      // A front takes as long as one of its texels, however few they are.
      pixels_queued += window * static_cast<std::int64_t>(
                                    std::max(some, static_cast<std::size_t>(std::max(1, device.info().num_units))));
      if (pixels_queued >= most) wait(control);
    }
  }
  void wait(const RunControl& control) {
    device.finish();
    pixels_queued = 0;
    control.throw_if_stopped();
  }
};

std::int64_t area(const SearchWindow& window) { return std::int64_t{window.x1 - window.x0} * (window.y1 - window.y0); }

}  // namespace

struct ReferenceOnDevice::State {
  SourceOnDevice source;
  AlikeOnDevice alike;
  NeighborsOnDevice neighbors;
  Buffer<std::uint16_t> targets;
  PlacesOnDevice places;
  Buffer<std::uint32_t> texels;      ///< Front by front.
  std::vector<std::size_t> begin{};  ///< Of each, and the end of the last.
  device::Kernel place;
  std::int64_t window;  ///< Pixels.

  State(const Device& device, const SourceLevel& level, const DestinationLevel& destination,
        const Neighborhood& neighborhood, const ReferenceOptions& options, const RunControl& control)
      : source(device, level, neighborhood, destination.num_controls(), control),
        alike(device, level),
        neighbors(device, destination, control),
        targets(device.upload(destination.controls.values())),
        places(device, *destination.map),
        place(source.program.kernel("place_front")),
        window(area(window_kernel::window_around(0, 0, options.window_px, level.width(), level.height()))) {}
};

ReferenceOnDevice::ReferenceOnDevice(const SearchDevice& device, const SourceLevel& source,
                                     const DestinationLevel& destination, const Neighborhood& neighborhood,
                                     std::span<const std::vector<TexelId>> fronts, std::uint64_t seed,
                                     const ReferenceOptions& options, const RunControl& control)
    : state_(std::make_unique<State>(device.device(), source, destination, neighborhood, options, control.silent())) {
  State& s = *state_;
  std::vector<std::uint32_t> texels;
  for (const std::vector<TexelId>& front : fronts) {
    s.begin.push_back(texels.size());
    for (const TexelId t : front) texels.push_back(static_cast<std::uint32_t>(t));
  }
  s.begin.push_back(texels.size());
  s.texels = s.source.device.upload(texels);
  window_kernel::WindowNumbers& numbers = s.source.numbers;
  numbers.seed = seed;
  numbers.epsilon = options.epsilon;
  numbers.tolerance = static_cast<std::int32_t>(options.tolerance * kControlSteps);
  numbers.window_px = options.window_px;
}
ReferenceOnDevice::~ReferenceOnDevice() = default;

void ReferenceOnDevice::run(const EnergyScale& scale, int pass, std::size_t first, std::size_t last, PlaceMap& places,
                            const RunControl& control) {
  State& s = *state_;
  const NeighborsOnDevice& n = s.neighbors;
  const search_kernel::PlaceTables tables = places.tables();
  s.source.numbers.reciprocal = tables.reciprocal;
  s.source.numbers.shift = tables.shift;
  s.source.numbers.stream = static_cast<std::uint32_t>(pass);
  s.source.set(scale);
  s.places.give(places);
  for (std::size_t front = first; front < last; ++front) {
    s.source.run(s.place, s.begin[front], s.begin[front + 1] - s.begin[front], s.window, control, s.alike.usable,
                 s.alike.first_with, s.alike.grid_cell, s.alike.grid_begin, s.alike.grid_pixels, s.targets, n.row,
                 n.is_stored, n.begin, n.stored, n.triangle, n.steps_of, n.steps, s.texels, s.places.pixels(),
                 s.places.beside());
  }
  s.source.wait(control);
  s.places.read();
  s.places.take(places);
}

struct AuditOnDevice::State {
  const SynthesisLevel& level;
  SourceOnDevice source;
  device::Kernel audit;

  State(const Device& device, const SynthesisLevel& audited, const Neighborhood& neighborhood,
        const RunControl& control)
      : level(audited),
        source(device, audited.source, neighborhood, audited.destination.num_controls(), control),
        audit(source.program.kernel("audit_texels")) {}
};

AuditOnDevice::AuditOnDevice(const SearchDevice& device, const SynthesisLevel& level, const Neighborhood& neighborhood,
                             const EnergyScale& scale, const RunControl& control)
    : state_(std::make_unique<State>(device.device(), level, neighborhood, control.silent())) {
  state_->source.set(scale);
}
AuditOnDevice::~AuditOnDevice() = default;

std::vector<AuditedTexel> AuditOnDevice::run(std::span<const TexelId> texels, const CoordinateMap& coordinates,
                                             const RunControl& control) {
  State& s = *state_;
  const DestinationLevel& destination = s.level.destination;
  // The texels' neighbors as an atlas of their own.
  std::vector<neighbor_kernel::PackedNeighbor> neighbors;
  std::vector<std::int32_t> seen, own;
  std::vector<std::uint16_t> targets;
  TexelNeighborhood::Cursor cursor(*destination.neighbors);
  for (const TexelId t : texels) {
    own.push_back(coordinates[static_cast<std::size_t>(t)]);
    const auto target = destination.target(t);
    targets.insert(targets.end(), target.begin(), target.end());
    for (const PixelNeighbor& n : cursor.at(t)) {
      const bool is_there = n.texel >= 0 && n.texel != t;
      neighbors.push_back({is_there ? static_cast<std::int32_t>(seen.size()) : -1, n.x, n.y});
      if (is_there) seen.push_back(coordinates[static_cast<std::size_t>(n.texel)]);
    }
  }
  const Device& device = s.source.device;
  const auto neighbors_there = device.upload(neighbors);
  const auto seen_there = device.upload(seen), own_there = device.upload(own);
  const auto targets_there = device.upload(targets);
  const auto costs = device.allocate<std::int64_t>(texels.size()), least = device.allocate<std::int64_t>(texels.size());
  const SourceLevel& source = s.level.source;
  s.source.run(s.audit, 0, texels.size(), std::int64_t{source.width()} * source.height(), control, neighbors_there,
               seen_there, own_there, targets_there, costs, least);
  s.source.wait(control);
  std::vector<std::int64_t> read(2 * texels.size());
  device.read(costs, std::span(read).first(texels.size()));
  device.read(least, std::span(read).subspan(texels.size()));
  std::vector<AuditedTexel> audited;
  for (std::size_t i = 0; i < texels.size(); ++i) audited.push_back({.own = read[i], .least = read[texels.size() + i]});
  return audited;
}

}  // namespace patinate::transfer
