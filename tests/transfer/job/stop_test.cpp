// A stop is noticed wherever the work is.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "patinate/atlas/direction_field.h"
#include "patinate/transfer/transfer.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/synthesis/audit.h"
#include "transfer/synthesis/multi_level.h"
#include "transfer/synthesis/reference.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {
namespace {

constexpr int kSide = 64;

/// A history, and a plane that it goes to.
struct Task {
  testing_support::TempFolder folder;
  std::shared_ptr<const HistoryReader> history;
  std::shared_ptr<const TexelMap> map = std::make_shared<TexelMap>(testing_support::unit_plane(kSide), kSide, kSide);
  TransferControl guide{"x", "x", ImageF(kSide, kSide), {}, 1.0, ControlMapping::Rank};

  Task() {
    testing_support::write_history(folder.path(), kSide, kSide, 3, testing_support::blotches);
    history = std::make_shared<const HistoryReader>(folder.path());
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) guide.values.at(x, y) = static_cast<float>(x + y) / static_cast<float>(2 * kSide);
    }
  }
};

TEST(Stop, ATransferEndsAtAnyMomentOfItsProgress) {
  constexpr int kThreads = 2;  // Pieces that may be under way.
  const Task task;
  for (TransferMethod method : {TransferMethod::Fast, TransferMethod::Reference}) {
    TransferOptions options;
    options.method = method;
    for (double moment : {0.0, 0.1, 0.25, 0.3, 0.36, 0.5, 0.7, 0.9, 0.96}) {
      std::stop_source source;
      int later = 0;
      RunControl control;
      control.num_threads = kThreads;
      control.stop = source.get_token();
      control.on_progress = [&](double done) {
        if (source.stop_requested())
          ++later;
        else if (done >= moment)
          source.request_stop();
      };
      EXPECT_THROW(
          (void)transfer({.history = task.history, .map = task.map, .texel_size_mm = 1.0, .controls = {task.guide}},
                         options, control),
          Canceled)
          << moment;
      EXPECT_LE(later, kThreads) << "begun after the stop at " << moment;
    }
  }
}

TEST(Stop, EveryStageOfATransferNoticesIt) {
  const Task task;
  std::stop_source source;
  source.request_stop();
  RunControl stopped;
  stopped.stop = source.get_token();
  const std::vector<double> weights{1.0};
  const Neighborhood neighborhood = Neighborhood::square(3);
  const std::vector<ImageF> known{task.history->read_control("x")};
  const ImageU8 mask = task.history->read_mask();
  const AppearanceSpace appearance = build_appearance_space(*task.history, 2);
  SynthesisLevel level{
      make_source_level(appearance.levels[0], interleave(known), mask, appearance.variances[0], neighborhood), {}};
  const SourcePlacement placement = place_source(*task.map, nullptr, 1.0, 0);
  level.destination =
      make_destination_level(task.map, interleave(std::vector<ImageF>{task.guide.values}), neighborhood, placement);
  const CoordinateMap coordinates(static_cast<std::size_t>(task.map->num_texels()), level.source.usable.front());
  const std::vector<std::pair<const char*, std::function<void()>>> stages{
      {"appearance", [&] { (void)build_appearance_space(*task.history, 2, {}, stopped); }},
      {"controls",
       [&] {
         (void)match_control(task.guide.values, task.map->coverage(), {}, known[0], mask, {}, ControlMapping::Rank,
                             stopped);
       }},
      {"levels of controls", [&] { (void)source_control_levels(appearance, known, stopped); }},
      {"texels", [&] { TexelMap(task.map->mesh(), kSide, kSide, stopped); }},
      {"directions", [&] { (void)direction_frames(*task.map, DirectionKind::Gravity, Vec3(0, 1, 0), stopped); }},
      {"neighbors",
       [&] { (void)make_destination_level(task.map, level.destination.controls, neighborhood, placement, stopped); }},
      {"reference",
       [&] {
         (void)synthesize_reference(level.source, level.destination, neighborhood, 0.5, weights, 1, {}, stopped);
       }},
      {"fast",
       [&, levels = std::vector<SynthesisLevel>{level}]() mutable {
         (void)synthesize_multi_level(levels, neighborhood, 0.5, weights, 1, {}, stopped);
       }},
      {"energy",
       [&] {
         (void)measure_energy(level.source, level.destination, neighborhood, coordinates, 0.5, weights, stopped);
       }},
      {"audit", [&] { (void)audit_optimum(level, neighborhood, coordinates, 0.5, weights, 10, 1, stopped); }}};
  for (const auto& [name, run] : stages) EXPECT_THROW(run(), Canceled) << name;
}

}  // namespace
}  // namespace patinate::transfer
