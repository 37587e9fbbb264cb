// Prints how fast the exact search of the reference method is, against looking at every pixel of its window; no test,
// no threshold. Run it in a release build on a quiet machine:
//     build/release/bin/search_benchmark [HISTORY CONTROL]
// HISTORY: a history of about 512 x 512 pixels, such as `patinate ingest` makes of a photograph and its height map;
// without one, blotches. The texels lie as the fast method leaves them: what a later pass of the reference meets.
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/history/history.h"
#include "patinate/transfer/transfer.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/window_search.h"

namespace patinate {
namespace {

constexpr int kAtlas = 512;

transfer::ControlImage as_integers(const ImageF& control) {
  transfer::ControlImage result(control.width(), control.height());
  for (std::size_t i = 0; i < result.values().size(); ++i)
    result.data()[i] =
        static_cast<std::uint16_t>(std::clamp(control.data()[i], 0.0f, 1.0f) * transfer::kControlSteps + 0.5f);
  return result;
}

/// A smooth guide over a plane with the source's distribution of values, and where the fast method takes each texel
/// from.
struct SearchSetting {
  transfer::Neighborhood neighborhood = transfer::Neighborhood::square(3);
  transfer::SourceLevel source;
  transfer::DestinationLevel destination;
  transfer::CoordinateMap coordinates;

  SearchSetting(const std::shared_ptr<const HistoryReader>& history, const std::string& control) {
    transfer::AppearanceSpace appearance = transfer::build_appearance_space(*history, 1);
    source = transfer::make_source_level(std::move(appearance.levels[0]), as_integers(history->read_control(control)),
                                         appearance.masks[0], appearance.variances[0], neighborhood);
    const auto map = std::make_shared<TexelMap>(testing_support::unit_plane(kAtlas), kAtlas, kAtlas);
    ImageF guide(kAtlas, kAtlas);
    for (int y = 0; y < kAtlas; ++y) {
      for (int x = 0; x < kAtlas; ++x)
        guide.at(x, y) =
            static_cast<float>(((x / 2 + y / 3) % 256 < 128 ? x / 2 + y / 3 : 255 - (x / 2 + y / 3) % 256) % 256) /
            255.0f;
    }
    const transfer::TransferResult fast =
        transfer::transfer({.history = history,
                            .map = map,
                            .texel_size_mm = 1.0,
                            .controls = {{control, "guide", guide, {}, 1.0, transfer::ControlMapping::Rank}}});
    coordinates = fast.coordinates;
    destination = transfer::make_destination_level(
        map, fast.matched_controls, neighborhood,
        {.frames = std::make_shared<const FlowFrames>(uv_frames(*map)), .pixel_mm = 1.0, .step_mm = 1.0});
  }
};

/// Texels a second. @param side  Of the window, around the texel's own place. @param is_pruned  Else every pixel is
/// looked at.
double rate(const SearchSetting& s, const transfer::WindowSearch& search, double coherence_share, int side,
            bool is_pruned, std::int64_t num_texels, int threads, std::int64_t* sum_of_costs) {
  RunControl control;
  control.num_threads = threads;
  const transfer::EnergyScale scale = transfer::EnergyScale::make(s.source, coherence_share, std::vector<double>{1.0});
  std::int64_t costs = 0;
  const double time_s = benchmarks::seconds([&] {
    costs = parallel_reduce(
        num_texels, 256, control, std::int64_t{0},
        [&](std::int64_t begin, std::int64_t end) {
          transfer::TexelCost cost(s.source, s.destination, s.neighborhood);
          std::int64_t sum = 0;
          for (std::int64_t i = begin; i < end; ++i) {
            const TexelId t = RandomStream(3, static_cast<std::uint64_t>(i))
                                  .below(static_cast<std::uint32_t>(s.destination.map->num_texels()));
            const std::int32_t own = s.coordinates[t], width = s.source.width();
            cost.prepare(t, s.coordinates, scale);
            std::array<std::int32_t, TexelNeighborhood::kNumAdjacent> likely{};
            std::transform(cost.adjacent().begin(), cost.adjacent().end(), likely.begin(), [&](const PixelNeighbor& n) {
              const transfer::Place at =
                  n.texel < 0 ? transfer::Place{} : transfer::place_of(s.source, s.coordinates[n.texel]);
              return at.pixel < 0 ? -1 : transfer::place_at(s.source, {at.point.x - n.x, at.point.y - n.y}).pixel;
            });
            const transfer::SearchWindow window = search.window(own % width, own / width, side);
            sum += (is_pruned ? search.find(cost, window, likely) : search.find_exhaustively(cost, window)).cost >> 10;
          }
          return sum;
        },
        [](std::int64_t a, std::int64_t b) { return a + b; });
  });
  if (sum_of_costs != nullptr) *sum_of_costs = costs;
  return static_cast<double>(num_texels) / time_s;
}

void compare_searches(const SearchSetting& s) {
  struct Case {
    const char* name;
    int side;
    std::int64_t few, many;  ///< Texels of the exhaustive and of the pruned search.
  };
  for (const Case& c : {Case{"window of 100 x 100", 100, 4096, 65536}, Case{"whole source", 1 << 20, 128, 4096}}) {
    const transfer::WindowSearch search(s.source, s.neighborhood, c.side);
    for (double control_weight : {0.5, 0.05}) {
      std::int64_t slow_costs = 0, fast_costs = 0;
      const double slow = rate(s, search, 1.0 - control_weight, c.side, false, c.few, 1, &slow_costs);
      (void)rate(s, search, 1.0 - control_weight, c.side, true, c.few, 1, &fast_costs);
      const double one = rate(s, search, 1.0 - control_weight, c.side, true, c.many, 1, nullptr),
                   two = rate(s, search, 1.0 - control_weight, c.side, true, c.many, 2, nullptr);
      std::printf(
          "%s, control weight %.2f, k texels/s: every pixel %.2f, pruned %.1f (%.0f times), on 2 threads %.1f; sums of "
          "optima %s\n",
          c.name, control_weight, 1e-3 * slow, 1e-3 * one, one / slow, 1e-3 * two,
          slow_costs == fast_costs ? "equal" : "DIFFER");
    }
  }
}

}  // namespace
}  // namespace patinate

int main(int argc, char** argv) {
  const patinate::testing_support::TempFolder folder;
  if (argc < 3)
    patinate::testing_support::write_history(folder.path(), 512, 512, 1, patinate::testing_support::blotches);
  const auto history =
      std::make_shared<const patinate::HistoryReader>(argc < 3 ? folder.path() : std::filesystem::path(argv[1]));
  patinate::compare_searches(patinate::SearchSetting(history, argc < 3 ? "x" : argv[2]));
}
