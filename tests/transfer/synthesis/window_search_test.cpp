#include "transfer/synthesis/window_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/atlas/direction_field.h"
#include "tests/support/meshes.h"
#include "transfer/synthesis/wavefronts.h"

namespace patinate::transfer {
namespace {

/// Smooth appearance and control over a source, with places that are equal, so that ties occur; and a plane of texels.
struct SearchTask {
  static constexpr int kSide = 72;
  Neighborhood neighborhood = Neighborhood::square(3);
  SourceLevel source;
  DestinationLevel destination;

  explicit SearchTask(int num_controls, const Mesh& mesh = testing_support::unit_plane(64.0), int resolution = 64) {
    AppearanceImage appearance(kSide, kSide, kAppearanceSize);
    ControlImage controls(kSide, kSide, num_controls);
    ImageU8 mask(kSide, kSide, 1, 255);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const int fx = x % 48, fy = y % 40;  // Repeats: equal costs.
        for (int c = 0; c < kAppearanceSize; ++c)
          appearance.at(x, y, c) =
              static_cast<std::int16_t>((fx * (13 + c) + fy * (29 - 3 * c)) % (600 >> c) - (300 >> c));
        for (int c = 0; c < num_controls; ++c)
          controls.at(x, y, c) = static_cast<std::uint16_t>((fx * 60 + fy * (11 + 17 * c)) % (kControlSteps + 1));
        if ((x - 30) * (x - 30) + (y - 50) * (y - 50) < 40) mask.at(x, y) = 0;
      }
    }
    source = make_source_level(std::move(appearance), std::move(controls), mask, 20000.0, neighborhood);
    auto map = std::make_shared<TexelMap>(mesh, resolution, resolution);
    ControlImage wanted(resolution, resolution, num_controls);
    for (std::int64_t i = 0; i < wanted.num_pixels() * num_controls; ++i)
      wanted.data()[i] =
          static_cast<std::uint16_t>(RandomStream(5, static_cast<std::uint64_t>(i)).below(kControlSteps + 1));
    destination = make_destination_level(map, std::move(wanted), neighborhood,
                                         {.frames = std::make_shared<const FlowFrames>(uv_frames(*map)),
                                          .pixel_mm = map->median_texel_size_mm(),
                                          .step_mm = map->median_texel_size_mm()});
  }
};

struct AuditCase {
  std::vector<double> weights{1.0};
  double coherence_share = 0.5;
  int side = 24;
  std::int64_t count = 1000;
};

/// Which neighbors have coordinates.
enum class Known { All, OfSomeQuarters, Some };

bool has_coordinates(Known known, const Offset& o, unsigned quarters, RandomStream& random) {
  if (known == Known::Some) return random.below(7) != 0;
  return known == Known::All || (quarters >> quarter_of(o) & 1U) != 0 || random.below(3) == 0;
}

std::vector<std::int32_t> all_within(const SourceLevel& source, const TexelCost& cost, const SearchWindow& window,
                                     std::int64_t bound) {
  std::vector<std::int32_t> pixels;
  for (int y = window.y0; y < window.y1; ++y) {
    for (int x = window.x0; x < window.x1; ++x) {
      const std::int32_t p = y * source.width() + x;
      if (source.is_usable[p] != 0 && cost.total(p, bound + 1) <= bound) pixels.push_back(p);
    }
  }
  return pixels;
}

/// Audits texels in random surroundings, some of them copied from one place so that coherent pixels are good. @returns
/// how many differ.
std::int64_t count_differences(const SearchTask& task, Known known, const AuditCase& c) {
  const WindowSearch search(task.source, task.neighborhood, c.side);
  const EnergyScale scale = EnergyScale::make(task.source, c.coherence_share, c.weights);
  const auto& usable = task.source.usable;
  return parallel_reduce(
      c.count, 512, RunControl{}, std::int64_t{0},
      [&](std::int64_t begin, std::int64_t end) {
        TexelCost cost(task.source, task.destination, task.neighborhood);
        std::int64_t different = 0;
        CoordinateMap coordinates(static_cast<std::size_t>(task.destination.map->num_texels()), -1);
        for (std::int64_t i = begin; i < end; ++i) {
          RandomStream random(11, static_cast<std::uint64_t>(i));
          const auto pick = [&] { return usable[random.below(static_cast<std::uint32_t>(usable.size()))]; };
          const TexelId t =
              task.destination.texels[random.below(static_cast<std::uint32_t>(task.destination.texels.size()))];
          const std::int32_t origin = pick();
          const std::uint32_t copied = random.below(5), quarters = random.below(kAllQuarters + 1);  // Of 4 neighbors.
          const int w = task.destination.map->width();
          for (int dy = -3; dy <= 3; ++dy) {
            for (int dx = -3; dx <= 3; ++dx) {
              const std::int64_t n = t + std::int64_t{dy} * w + dx;
              if (n < 0 || n >= task.destination.map->num_texels()) continue;
              const std::int32_t shifted = origin + dy * task.source.width() + dx;
              coordinates[n] = !has_coordinates(known, {dx, dy}, quarters, random) ? -1
                               : random.below(4) < copied                          ? shifted
                                                                                   : pick();
            }
          }
          cost.prepare(t, coordinates, scale);
          const SearchWindow window =
              search.window(random.below(SearchTask::kSide), random.below(SearchTask::kSide), c.side);
          const std::array<std::int32_t, 3> likely{random.below(8) == 0 ? -1 : origin, -1, pick()};
          const WindowOptimum fast = search.find(cost, window, likely), slow = search.find_exhaustively(cost, window);
          different += fast.pixel != slow.pixel || (fast.pixel >= 0 && fast.cost != slow.cost) ? 1 : 0;
          if (slow.pixel < 0 || i % 8 != 0) continue;
          const std::int64_t bound = slow.cost + slow.cost / 4;
          different += search.find_within(cost, window, bound) == all_within(task.source, cost, window, bound) ? 0 : 1;
        }
        return different;
      },
      [](std::int64_t a, std::int64_t b) { return a + b; });
}

TEST(WindowSearch, FindsWhatLookingAtEveryPixelFindsInAHundredThousandTexels) {
  const SearchTask one(1), two(2);
  for (const Known known : {Known::All, Known::OfSomeQuarters, Known::Some}) {
    const auto differences = [&](const SearchTask& task, const AuditCase& c) {
      return count_differences(task, known, c);
    };
    EXPECT_EQ(differences(one, {.coherence_share = 0.5, .count = 14000}), 0);
    EXPECT_EQ(differences(one, {.coherence_share = 0.95, .count = 14000}), 0);
    EXPECT_EQ(differences(two, {.weights = {1.0, 0.3}, .side = 33, .count = 7000}), 0);
    EXPECT_EQ(differences(one, {.side = 4096}), 0) << "the whole source";
    EXPECT_EQ(differences(one, {.coherence_share = 1.0, .side = 40}), 0) << "no control";
    EXPECT_EQ(differences(one, {.coherence_share = 0.0, .side = 40}), 0) << "control alone";
    EXPECT_EQ(differences(one, {.coherence_share = 0.001, .count = 4000}), 0) << "controls that are far off";
  }
}

TEST(Wavefronts, NeighborsAreVisitedInRowOrderAlsoAcrossSeams) {
  const SearchTask task(1, testing_support::cut_plane(64.0), 96);
  const auto fronts = wavefronts(task.destination);
  std::vector<std::int32_t> front_of(static_cast<std::size_t>(task.destination.map->num_texels()), -1);
  std::size_t visited = 0;
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    for (TexelId t : fronts[f]) front_of[t] = static_cast<std::int32_t>(f);
    visited += fronts[f].size();
  }
  EXPECT_EQ(visited, task.destination.texels.size());
  TexelNeighborhood::Cursor cursor(*task.destination.neighbors);
  std::int64_t wrong = 0;
  for (TexelId t : task.destination.texels) {
    for (const PixelNeighbor& neighbor : cursor.at(t)) {
      const TexelId n = neighbor.texel;
      if (n < 0 || n == t) continue;
      const std::int32_t a = front_of[t], b = front_of[n];
      wrong += (n < t) != (b < a) ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(fronts.size(), task.destination.texels.size() / 8) << "many at a time";
}

}  // namespace
}  // namespace patinate::transfer
