#include "patinate/atlas/direction_field.h"
#include "transfer/synthesis/multi_level.h"
#include "transfer/synthesis/search_device.h"

namespace patinate::transfer {

namespace {

/// A square of `size` mm, its halves in two charts beside one another: neighbors by the grid, and stored ones.
Mesh two_charts(double size) {
  Mesh mesh;
  for (const double y : {0.0, size}) {
    for (const double x : {0.0, size / 2, size}) mesh.positions.push_back(Vec3(x, y, 0));
    for (const double u : {0.0, 0.5, 0.5, 1.0}) mesh.uvs.push_back(Vec2(u, y / size));
  }
  for (const int half : {0, 1}) {
    const int p = half, uv = 2 * half;
    mesh.triangles.insert(mesh.triangles.end(), {{p, p + 1, p + 4}, {p, p + 4, p + 3}});
    mesh.uv_triangles.insert(mesh.uv_triangles.end(), {{uv, uv + 1, uv + 5}, {uv, uv + 5, uv + 4}});
  }
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces.push_back({});
  return mesh;
}

SynthesisLevel check_level(const Neighborhood& neighborhood) {
  constexpr int kSource_px = 56, kSize = 64;
  AppearanceImage appearance(kSource_px, kSource_px, kAppearanceSize);
  ControlImage source(kSource_px, kSource_px, 1), wanted(kSize, kSize, 1);
  for (int y = 0; y < kSource_px; ++y) {
    for (int x = 0; x < kSource_px; ++x) {
      RandomStream random(7, static_cast<std::uint64_t>(y / 3 * kSource_px + x / 3));
      for (int d = 0; d < kAppearanceSize; ++d)
        appearance.at(x, y, d) = static_cast<std::int16_t>(static_cast<int>(random.below(1023)) - 511);
      source.at(x, y) =
          static_cast<std::uint16_t>((x * kControlSteps + static_cast<int>(random.below(400))) / (kSource_px + 8));
    }
  }
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) wanted.at(x, y) = static_cast<std::uint16_t>(y * kControlSteps / kSize);
  }
  const auto map = std::make_shared<const TexelMap>(two_charts(kSize), kSize, kSize);
  const auto frames = std::make_shared<const FlowFrames>(direction_frames(*map, DirectionKind::Uv, Vec3(0, 1, 0)));
  SynthesisLevel level{
      .source = make_source_level(std::move(appearance), std::move(source), ImageU8(kSource_px, kSource_px, 1, 255),
                                  40'000.0, neighborhood),
      // Pixels of 1.3 texels: places lie beside the middles of pixels.
      .destination = cover_level(map, std::move(wanted), {.frames = frames, .pixel_mm = 1.3, .step_mm = 1.3})};
  return level;
}

constexpr int kRadius_px = 3;

CostSums sums_here(const SynthesisLevel& level, const Neighborhood& neighborhood, const CoordinateMap& coordinates,
                   std::span<const double> weights) {
  const EnergyFigures figures = measure_figures(level.source, level.destination, neighborhood, coordinates, weights);
  return {.coherence = figures.coherence, .control = figures.control};
}

}  // namespace

device::CheckResult check_search(const device::Device& device) {
  const Neighborhood neighborhood = Neighborhood::square(kRadius_px);
  const std::array weights{1.0};
  const auto synthesize = [&](const SearchDevice* there) {
    std::vector<SynthesisLevel> levels;
    levels.push_back(check_level(neighborhood));
    std::unique_ptr<SearchDevice::Level> kept;
    PlaceMap places =
        synthesize_multi_level(levels, neighborhood, 0.65, weights, 1, {.fine_passes = 4}, {}, {}, there, &kept);
    const SynthesisLevel& level = levels[0];
    const CostSums sums = kept != nullptr ? kept->sum_costs(full_scale(level.source, weights), places.pixels, {})
                                          : sums_here(level, neighborhood, places.pixels, weights);
    return std::pair(std::move(places), sums);
  };
  std::optional<device::DeviceError> failure;
  const SearchDevice search(device, [&](const device::DeviceError& problem) { failure = problem; });
  const auto [there, sums_there] = synthesize(&search);
  const auto [here, sums_of_cpu] = synthesize(nullptr);
  if (failure) throw device::DeviceError(*failure);
  const auto num_texels = static_cast<std::int64_t>(here.pixels.size());
  device::CheckResult check{.num_items = num_texels + 2};
  for (TexelId t = 0; t < num_texels; ++t) check.num_different += there.at(t) == here.at(t) ? 0 : 1;
  check.num_different += sums_there.coherence == sums_of_cpu.coherence ? 0 : 1;
  check.num_different += sums_there.control == sums_of_cpu.control ? 0 : 1;
  return check;
}

}  // namespace patinate::transfer
