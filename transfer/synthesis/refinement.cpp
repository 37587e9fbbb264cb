#include "transfer/synthesis/refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/surface_patch.h"

namespace patinate::transfer {

namespace {

constexpr int kBlock = 8;  // Texels.

int num_blocks(int texels) { return (texels + kBlock - 1) / kBlock; }

constexpr double kStructureWeight = 1000.0;  // Weight of 1 of structure; 170 is the spread of the appearance. Lower,
                                             // and lines are erased: 680 lost a tenth of them.
constexpr double kControlUnit = 4.5;  // Found by trial on synthetic crackle, with a share of a half: twice as much
                                      // brings the control error down by a fifth, and breaks more lines.
/// Windows where the borders of a texel cost less are left: its pairs differ by a tenth of the appearance's
/// spread on the mean. Chosen from 0, 100, 200 and 300 on synthetic crackle: lower values cut cells open again.
constexpr std::int64_t kMinTexelCost = 200;
constexpr int kNumSweeps = 30;  // Reach as far as 8 texels; 8 sweeps bring half as much on the urn.
/// Half sides of windows, source pixels (docs/algorithms/refinement.md).
constexpr int kSmallestHalf_px = 8, kLargestHalf_px = 44;
constexpr std::array kHalfFactors{0.4, 0.6, 0.9, 1.3, 2.0};  // Half factors of the size of cells.

int half_px(double factor, const SourceStructure& structure) {
  return std::clamp(static_cast<int>(factor * structure.scale_px), kSmallestHalf_px, kLargestHalf_px);
}

}  // namespace

BlockCosts::BlockCosts(const DestinationLevel& destination, const TexelNeighborhood& beside,
                       const SeamFeatures& features)
    : map_(*destination.map),
      turns_(destination.placement.turns.get()),
      beside_(beside),
      features_(features),
      columns_(num_blocks(map_.width())),
      rows_(num_blocks(map_.height())),
      costs_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      num_texels_(costs_.size()) {}

void BlockCosts::measure(const TexelSet& texels, const PlaceMap& places, const RunControl& control) {
  parallel_for(rows_, 1, control, [&](std::int64_t begin, std::int64_t end) {
    TexelNeighborhood::Cursor cursor(beside_);
    for (std::int64_t row = begin; row < end; ++row) {
      std::int64_t* const first = costs_.data() + row * columns_;
      std::fill(first, first + columns_, 0);
      std::int32_t* const counts = num_texels_.data() + row * columns_;
      std::fill(counts, counts + columns_, 0);
      const int y0 = static_cast<int>(row) * kBlock;
      for (int y = y0; y < std::min(y0 + kBlock, map_.height()); ++y) {
        for (int x = 0; x < map_.width(); ++x) {
          const TexelId t = TexelId{y} * map_.width() + x;
          if (!texels.contains(t)) continue;
          first[x / kBlock] += texel_cost(t, cursor, places);
          ++counts[x / kBlock];
        }
      }
    }
  });
}

BlockCosts::Sum BlockCosts::around(std::size_t block) const {
  const int at = static_cast<int>(block), x = at % columns_, y = at / columns_;
  Sum sum;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (x + dx < 0 || x + dx >= columns_ || y + dy < 0 || y + dy >= rows_) continue;
      const std::int64_t beside = std::int64_t{y + dy} * columns_ + x + dx;
      sum.cost += costs_[beside];
      sum.num_texels += num_texels_[beside];
    }
  }
  return sum;
}

TexelId BlockCosts::texel_in(std::size_t block) const {
  const int at = static_cast<int>(block), x0 = at % columns_ * kBlock, y0 = at / columns_ * kBlock;
  TexelId best = -1;
  int least = kBlock * kBlock;
  for (int y = y0; y < std::min(y0 + kBlock, map_.height()); ++y) {
    for (int x = x0; x < std::min(x0 + kBlock, map_.width()); ++x) {
      const TexelId t = TexelId{y} * map_.width() + x;
      const int away = std::abs(x - x0 - kBlock / 2) + std::abs(y - y0 - kBlock / 2);
      if (!map_.is_covered(t) || away >= least) continue;
      best = t;
      least = away;
    }
  }
  return best;
}

std::int64_t BlockCosts::texel_cost(TexelId t, TexelNeighborhood::Cursor& cursor, const PlaceMap& places) const {
  const Place here = places.at(t);
  std::int64_t sum = 0;
  for_each_pair(t, cursor.at(t).subspan(beside_.first_adjacent()), map_.width(),
                [&](const PixelNeighbor& n, bool is_earlier, int weight) {
                  if (is_earlier) return;
                  const Turn turn =
                      turns_ == nullptr ? Turn{0} : turns_->between(map_.triangle(t), map_.triangle(n.texel));
                  sum += weight * features_.seam(here, places.at(n.texel), {n.x, n.y}, turn);
                });
  return sum;
}

LevelRefiner::LevelRefiner(const SynthesisLevel& level, const SourceStructure& structure, const SimilarPixels& similar,
                           std::span<const double> control_weights, std::uint64_t seed,
                           const RefinementOptions& options, const TexelSet& texels, const RunControl& control)
    : level_(level),
      texels_(texels),
      has_structure_(!structure.empty()),
      beside_(*level.destination.map, {}, level.destination.placement.frames, level.destination.placement.pixel_mm,
              control),
      features_(level.source, structure.channels, kStructureWeight * structure.weight),
      control_cost_(level.source, control_weights, kControlUnit * options.control_share),
      amounts_(level.source),
      nearby_(level.source, *level.destination.map),
      task_{.source = level.source,
            .destination = level.destination,
            .features = features_,
            .control_cost = control_cost_,
            .similar = similar,
            .amounts = amounts_,
            .nearby = nearby_},
      seed_(seed),
      costs_(level.destination, beside_, features_),
      patience_(costs_.size(), kPatient),
      is_taken_(static_cast<std::size_t>(level.destination.map->num_texels()), 0) {
  for (double factor : kHalfFactors) halves_.push_back(half_px(factor, structure));
}

void LevelRefiner::round(int index, PlaceMap& places, const RunControl& control) {
  amounts_.measure(level_.destination, places, control);
  if (!has_structure_) nearby_.measure(places, control);
  costs_.measure(texels_, places, control);
  const std::vector<Wish> wishes = find_wishes();
  for (int& p : patience_) p += (kPatient - p) / 8;
  std::fill(is_taken_.begin(), is_taken_.end(), std::uint8_t{0});
  if (texels_.size() < level_.destination.texels.size()) {  // What must stay is as if a window beside had seen it.
    for (const TexelId t : level_.destination.texels) is_taken_[t] = texels_.contains(t) ? std::uint8_t{0} : kBeside;
  }

  PatchFinder finder(*level_.destination.map, beside_, level_.destination.placement.turns.get());
  std::span<const Wish> rest = wishes;
  for (std::vector<Window> windows = choose_windows(index, rest, finder, control), next; !windows.empty();
       std::swap(windows, next)) {
    // No window holds a texel beside another's: what one writes, no other reads. The next are chosen meanwhile.
    parallel_for(static_cast<std::int64_t>(windows.size()) + 1, 1, control, [&](std::int64_t begin, std::int64_t) {
      if (begin == 0)
        next = choose_windows(index, rest, finder, control);
      else
        improve(index, windows[begin - 1], places, control);
    });
    for (const Window& window : windows) {
      int& patience = patience_[window.block];
      patience = patience * (window.has_gained ? 9 : 6) / 10;
    }
  }
}

void LevelRefiner::improve(int index, Window& window, PlaceMap& places, const RunControl& control) const {
  PatchCut cut(task_);
  const RandomStream random(seed_, window.block, 3000 + static_cast<std::uint32_t>(index));
  window.has_gained = cut.improve(window.patch, places, random, control) > 0;
  if (!window.has_gained) return;
  for (std::size_t i = 0; i < window.patch.texels.size(); ++i)
    places.set(window.patch.texels[i].texel, cut.improved()[i]);
}

std::vector<LevelRefiner::Wish> LevelRefiner::find_wishes() const {
  std::vector<Wish> wishes;
  for (std::size_t b = 0; b < costs_.size(); ++b) {
    const BlockCosts::Sum around = costs_.around(b);
    if (around.cost > kMinTexelCost * around.num_texels) wishes.push_back({around.cost * patience_[b], b});
  }
  std::stable_sort(wishes.begin(), wishes.end(), [](const Wish& a, const Wish& b) { return a.priority > b.priority; });
  return wishes;
}

std::vector<LevelRefiner::Window> LevelRefiner::choose_windows(int index, std::span<const Wish>& wishes,
                                                               PatchFinder& finder, const RunControl& control) {
  std::vector<Window> windows;
  SurfacePatch patch;
  const std::size_t most = kBatchTexels * static_cast<std::size_t>(thread_count(control));
  std::size_t num_texels = 0;
  for (; !wishes.empty() && num_texels < most; wishes = wishes.subspan(1)) {
    const Wish& wish = wishes.front();
    if (wishes.size() % 256 == 0) control.throw_if_stopped();
    const TexelId center = costs_.texel_in(wish.block);
    if (center < 0 || is_taken_[center] != 0) continue;
    finder.find_texels(center, kSmallestHalf_px / 2, patch);  // Most have no room: this is quick.
    if (room_px(patch) < kSmallestHalf_px / 2) continue;
    RandomStream random(seed_, wish.block, 2000 + static_cast<std::uint32_t>(index));
    finder.find_texels(center, halves_[random.below(static_cast<std::uint32_t>(halves_.size()))], patch);
    const int room = room_px(patch);
    if (room < kSmallestHalf_px / 2) continue;
    if (room < patch.half_px) finder.find_texels(center, room, patch);
    finder.find_edges(patch);
    if (sees_a_member(patch) || holds_what_stays(patch)) continue;
    take(patch);
    num_texels += patch.texels.size();
    windows.push_back({.block = wish.block, .patch = std::move(patch)});
    patch = {};
  }
  return windows;
}

int LevelRefiner::room_px(const SurfacePatch& patch) const {
  std::int32_t room = patch.half_px * PixelNeighbor::kOne;
  for (const PatchTexel& t : patch.texels) {
    if (is_taken_[t.texel] != 0) room = std::min(room, std::max(std::abs(t.offset.x), std::abs(t.offset.y)) - 1);
  }
  return room / PixelNeighbor::kOne;
}

bool LevelRefiner::sees_a_member(const SurfacePatch& patch) const {
  return std::any_of(patch.edges.begin(), patch.edges.end(),
                     [&](const PatchEdge& e) { return e.outside >= 0 && is_taken_[e.outside] == kMember; });
}

bool LevelRefiner::holds_what_stays(const SurfacePatch& patch) const {
  return texels_.size() < level_.destination.texels.size() &&
         std::any_of(patch.texels.begin(), patch.texels.end(),
                     [&](const PatchTexel& t) { return !texels_.contains(t.texel); });
}

void LevelRefiner::take(const SurfacePatch& patch) {
  for (const PatchEdge& e : patch.edges) {
    if (e.outside >= 0) is_taken_[e.outside] = kBeside;
  }
  for (const PatchTexel& t : patch.texels) is_taken_[t.texel] = kMember;
}

void smooth_places(const SynthesisLevel& level, const TexelNeighborhood& beside, int num_sweeps, PlaceMap& places,
                   const RunControl& control, const TexelSet* region) {
  // Half a pixel: the next texel's source continues this one's.
  constexpr std::int32_t kSamePiece = PixelNeighbor::kOne / 2;
  constexpr std::int64_t kSmoothChunk = 16384;
  const TexelSet& texels = region == nullptr ? level.destination.texels : *region;
  const FrameTurns* const turns = level.destination.placement.turns.get();
  const TexelMap& map = *level.destination.map;
  std::vector<Place> next(texels.size());
  for (int sweep = 0; sweep < num_sweeps; ++sweep) {
    const auto for_some = [&](const auto& visit) {
      parallel_for(static_cast<std::int64_t>(texels.size()), kSmoothChunk, control,
                   [&](std::int64_t begin, std::int64_t end) {
                     TexelNeighborhood::Cursor cursor(beside);
                     auto at = texels.from(static_cast<std::size_t>(begin));
                     for (std::int64_t i = begin; i < end; ++i, ++at) visit(*at, static_cast<std::size_t>(i), cursor);
                   });
    };
    for_some([&](TexelId t, std::size_t i, TexelNeighborhood::Cursor& cursor) {
      const Place own = places.at(t);
      std::int32_t x = 0, y = 0, turn = 0, num = 1;
      for (const PixelNeighbor& n : cursor.at(t).subspan(beside.first_adjacent())) {
        if (n.texel < 0 || n.texel == t) continue;
        const Place other = places.at(n.texel);
        const FixedPoint step = turned({n.x, n.y}, own.turn);
        const std::int32_t dx = other.point.x - step.x - own.point.x, dy = other.point.y - step.y - own.point.y;
        if (other.pixel < 0 || std::abs(dx) > kSamePiece || std::abs(dy) > kSamePiece) continue;
        x += dx, y += dy, ++num;
        if (turns != nullptr)
          turn += difference_of(difference_of(other.turn, turns->between(map.triangle(t), map.triangle(n.texel))),
                                own.turn);
      }
      const auto mean = [&](std::int32_t sum) {
        return static_cast<std::int32_t>(std::floor((sum + 0.5 * num) / num));
      };
      const Place moved =
          place_at(level.source, {own.point.x + mean(x), own.point.y + mean(y)}, sum_of(own.turn, mean(turn)));
      next[i] = moved.pixel < 0 ? own : moved;
    });
    for_some([&](TexelId t, std::size_t i, TexelNeighborhood::Cursor&) { places.set(t, next[i]); });
  }
}

void refine_places(const SynthesisLevel& level, const SourceStructure& structure, const SimilarPixels& similar,
                   std::span<const double> control_weights, std::uint64_t seed, const RefinementOptions& options,
                   PlaceMap& places, const RunControl& control, const TexelSet* region) {
  const RunControl silent = control.silent();
  LevelRefiner refiner(level, structure, similar, control_weights, seed, options,
                       region == nullptr ? level.destination.texels : *region, silent);
  for (int round = 0; round < options.num_rounds; ++round) {
    refiner.round(round, places, silent);
    control.report(static_cast<double>(round + 1) / options.num_rounds);
  }
  smooth_places(level, refiner.beside(), kNumSweeps, places, silent, region);
}

}  // namespace patinate::transfer
