#include "transfer/synthesis/audit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "libcommon/core/random.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/transfer/transfer_io.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/synthesis/map_audit.h"
#include "transfer/synthesis/window_search.h"

namespace patinate::transfer {
namespace {

constexpr int kAuditSide = 64;
constexpr double kAuditShare = 0.75;

/// A blotchy history, and a plane on which a control that rises along x is wanted.
struct Task {
  testing_support::TempFolder folder;
  std::shared_ptr<const HistoryReader> history;
  std::shared_ptr<const TexelMap> map;
  TransferControl control;

  explicit Task(int resolution = 40, double side_mm = 40.0) {
    testing_support::write_history(folder.path(), kAuditSide, kAuditSide, 3, testing_support::blotches);
    history = std::make_shared<const HistoryReader>(folder.path());
    map = std::make_shared<TexelMap>(testing_support::unit_plane(side_mm), resolution, resolution);
    ImageF wanted(resolution, resolution);
    for (int y = 0; y < resolution; ++y) {
      for (int x = 0; x < resolution; ++x) wanted.at(x, y) = static_cast<float>(x) / static_cast<float>(resolution - 1);
    }
    control = {"x", "x", wanted, {}, 1.0, ControlMapping::Rank};
  }
  [[nodiscard]] MapToAudit audited(const ImageF& coordinates, const ImageF& wanted) const {
    return {.surface = map, .coordinates = coordinates, .pixel_mm = 1.0, .controls = {{"x", wanted, 1.0}}};
  }
};

/// Every texel from some usable pixel, or all as `where` says.
template <class Where>
ImageF coordinates_of(const TexelMap& map, Where&& where) {
  ImageF out(map.width(), map.height(), 2, -1.0f);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const auto [x, y] = where(t);
    out.data()[2 * t] = static_cast<float>(x);
    out.data()[2 * t + 1] = static_cast<float>(y);
  }
  return out;
}

/// The only control that was matched, as the synthesis compared it.
ImageF matched_values(const TransferResult& made) {
  ImageF values(made.matched_controls.width(), made.matched_controls.height());
  std::transform(made.matched_controls.values().begin(), made.matched_controls.values().end(), values.values().begin(),
                 [](std::uint16_t v) { return static_cast<float>(v) / kControlSteps; });
  return values;
}

/// A level like that of the audits, made by hand.
struct Level {
  Neighborhood neighborhood = Neighborhood::square(3);
  SynthesisLevel level;
  CoordinateMap coordinates;

  Level() {
    AppearanceImage appearance(kAuditSide, kAuditSide, kAppearanceSize);
    ControlImage controls(kAuditSide, kAuditSide, 1);
    for (int y = 0; y < kAuditSide; ++y) {
      for (int x = 0; x < kAuditSide; ++x) {
        for (int c = 0; c < kAppearanceSize; ++c)
          appearance.at(x, y, c) =
              static_cast<std::int16_t>((x * (13 + c) + y * (29 - 3 * c)) % (600 >> c) - (300 >> c));
        controls.at(x, y) = static_cast<std::uint16_t>((x * 60 + y * 11) % (kControlSteps + 1));
      }
    }
    level.source = make_source_level(std::move(appearance), std::move(controls),
                                     ImageU8(kAuditSide, kAuditSide, 1, 255), 20000.0, neighborhood);
    auto map = std::make_shared<TexelMap>(testing_support::cut_plane(24.0), 64, 64);
    ControlImage wanted(64, 64, 1);
    for (std::int64_t i = 0; i < wanted.num_pixels(); ++i)
      wanted.data()[i] =
          static_cast<std::uint16_t>(RandomStream(5, static_cast<std::uint64_t>(i)).below(kControlSteps + 1));
    const double texel_mm = map->median_texel_size_mm();
    level.destination = make_destination_level(
        map, std::move(wanted), neighborhood,
        {.frames = std::make_shared<const FlowFrames>(uv_frames(*map)), .pixel_mm = texel_mm, .step_mm = texel_mm});
    coordinates.assign(static_cast<std::size_t>(map->num_texels()), -1);
    for (TexelId t : level.destination.texels) {
      RandomStream random(8, static_cast<std::uint64_t>(t));
      coordinates[t] = level.source.usable[random.below(static_cast<std::uint32_t>(level.source.usable.size()))];
    }
  }
};

TEST(OptimumAudit, FindsWhatLookingAtEveryPixelFinds) {
  const Level task;
  const std::vector<double> weights{1.0};
  const WindowSearch search(task.level.source, task.neighborhood, kAuditSide);
  TexelCost cost(task.level.source, task.level.destination, task.neighborhood);
  double own = 0.0, least = 0.0;
  std::vector<double> ratios;
  for (TexelId t : task.level.destination.texels) {
    cost.prepare(t, task.coordinates, EnergyScale::make(task.level.source, kAuditShare, weights));
    const auto mine = static_cast<double>(cost.total(task.coordinates[t], std::numeric_limits<std::int64_t>::max()));
    const auto best = static_cast<double>(
        search.find_exhaustively(cost, {.x0 = 0, .y0 = 0, .x1 = kAuditSide, .y1 = kAuditSide}).cost);
    own += mine;
    least += best;
    ratios.push_back(mine / best);
  }
  std::sort(ratios.begin(), ratios.end());
  const OptimumAudit audit =
      audit_optimum(task.level, task.neighborhood, task.coordinates, kAuditShare, weights, 1'000'000, 1);
  EXPECT_EQ(audit.num_audited, static_cast<std::int64_t>(task.level.destination.texels.size()));
  EXPECT_EQ(audit.ratio, own / least);
  EXPECT_EQ(audit.median_ratio, ratios[ratios.size() / 2]);
  EXPECT_GT(*audit.ratio, 1.5) << "random pixels are far from the best";
}

TEST(OptimumAudit, TheBestPixelOfEveryTexelIsOptimal) {
  const Level task;
  const std::vector<double> weights{1.0};
  const WindowSearch search(task.level.source, task.neighborhood, kAuditSide);
  TexelCost cost(task.level.source, task.level.destination, task.neighborhood);
  // Control alone: no texel's best pixel depends on its neighbors.
  CoordinateMap best = task.coordinates;
  for (TexelId t : task.level.destination.texels) {
    cost.prepare(t, task.coordinates, EnergyScale::make(task.level.source, 0.0, weights));
    best[t] = search.find_exhaustively(cost, {.x0 = 0, .y0 = 0, .x1 = kAuditSide, .y1 = kAuditSide}).pixel;
  }
  const OptimumAudit audit = audit_optimum(task.level, task.neighborhood, best, 0.0, weights, 1'000'000, 1);
  EXPECT_EQ(audit.optimal_share, 1.0);
  EXPECT_EQ(audit.energy, audit.optimum);
  EXPECT_LT(audit_optimum(task.level, task.neighborhood, task.coordinates, 0.0, weights, 1'000'000, 1).optimal_share,
            0.05);
}

TEST(OptimumAudit, AFewTexelsEstimateAllOfThemTheSameWayOnAnyThread) {
  const Level task;
  const std::vector<double> weights{1.0};
  const auto audited = [&](std::int64_t count, std::uint64_t seed, int threads) {
    RunControl control;
    control.num_threads = threads;
    return audit_optimum(task.level, task.neighborhood, task.coordinates, kAuditShare, weights, count, seed, control);
  };
  const OptimumAudit all = audited(1'000'000, 1, 1), few = audited(300, 1, 1), again = audited(300, 1, 3),
                     other = audited(300, 2, 1);
  EXPECT_EQ(few.num_audited, 300);
  EXPECT_EQ(few.ratio, again.ratio);
  EXPECT_EQ(few.energy, again.energy);
  EXPECT_NE(few.energy, other.energy);
  // Costs of random texels spread by less than their mean: 4 sigma / sqrt(300).
  EXPECT_NEAR(few.energy, all.energy, 4.0 / std::sqrt(300.0) * all.energy);
}

TEST(OptimumAudit, PixelsAtTheBorderHaveNoCost) {
  Level task;
  const std::size_t n = task.level.destination.texels.size();
  for (std::size_t i = 0; i < n / 2; ++i) task.coordinates[task.level.destination.texels[i]] = 2;
  const OptimumAudit audit = audit_optimum(task.level, task.neighborhood, task.coordinates, kAuditShare,
                                           std::vector<double>{1.0}, 1'000'000, 1);
  EXPECT_EQ(audit.num_excluded, static_cast<std::int64_t>(n / 2));
  EXPECT_EQ(audit.num_audited, static_cast<std::int64_t>(n - n / 2));
  std::fill(task.coordinates.begin(), task.coordinates.end(), 2);
  EXPECT_FALSE(
      audit_optimum(task.level, task.neighborhood, task.coordinates, kAuditShare, std::vector<double>{1.0}, 100, 1)
          .ratio);
}

// The energy that transfer() reports and the audit's, of all texels, differ by the rounding of two integer scales.
TEST(MapAudit, OfAllTexelsHasTheEnergyThatTheTransferReports) {
  constexpr double kScaleRounding = 1e-3;
  for (const auto& [resolution, side_mm] :
       {std::pair{40, 40.0}, std::pair{32, 128.0}}) {  // Texels of a pixel, and of four: the history is halved twice.
    const Task task(resolution, side_mm);
    TransferOptions options;
    options.coherence_share = kAuditShare;
    const TransferResult made =
        transfer({.history = task.history, .map = task.map, .texel_size_mm = 1.0, .controls = {task.control}}, options);
    const ImageF coordinates = coordinate_image(made, resolution, resolution, kAuditSide);
    const OptimumAudit audit =
        audit_map(*task.history, task.audited(coordinates, matched_values(made)), options, 1'000'000, 1);
    EXPECT_EQ(audit.num_excluded, 0);
    EXPECT_EQ(audit.num_audited, task.map->num_covered());
    EXPECT_NEAR(audit.energy, made.energy.energy, kScaleRounding * made.energy.energy) << resolution;
    EXPECT_GE(audit.ratio.value(), 1.0);
    const ImageF elsewhere = coordinates_of(*task.map, [&](TexelId t) {
      RandomStream random(3, static_cast<std::uint64_t>(t));
      return std::pair{8 + random.below(kAuditSide - 16), 8 + random.below(kAuditSide - 16)};
    });
    EXPECT_GT(audit_map(*task.history, task.audited(elsewhere, matched_values(made)), options, 1'000'000, 1).energy,
              1.5 * audit.energy)
        << "a search beats chance";
  }
}

TEST(MapAudit, TheSourceItselfIsOptimal) {
  const Task task;
  // What the source has at (x + 10, y + 10) is wanted and shown.
  const ImageF known = task.history->read_control("x");
  ImageF wanted(40, 40);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) wanted.at(x, y) = known.at(x + 10, y + 10);
  }
  const ImageF same = coordinates_of(*task.map, [](TexelId t) { return std::pair{t % 40 + 10, t / 40 + 10}; });
  const OptimumAudit audit = audit_map(*task.history, task.audited(same, wanted), {}, 500, 1);
  EXPECT_EQ(audit.energy, 0.0);
  EXPECT_EQ(audit.optimal_share, 1.0);
  EXPECT_EQ(audit.ratio, 1.0);
  EXPECT_EQ(audit.median_ratio, 1.0);
}

TEST(MapAudit, SizesThatDoNotFitAreNamed) {
  const Task task;
  MapToAudit made = task.audited(ImageF(39, 40, 2), ImageF(40, 40));
  const auto error = [&] {
    return testing_support::error_of([&] { (void)audit_map(*task.history, made, {}, 10, 1); });
  };
  EXPECT_EQ(error(), "the coordinate map has not 40 x 40 texels with two channels");
  made = task.audited(ImageF(40, 40, 2), ImageF(40, 39));
  EXPECT_EQ(error(), "control `x` has not 40 x 40 values");
}

}  // namespace
}  // namespace patinate::transfer
