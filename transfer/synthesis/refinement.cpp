#include "transfer/synthesis/refinement.h"

#include <algorithm>
#include <array>
#include <vector>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/patch_cut.h"

namespace patinate::transfer {

namespace {

constexpr double kStructureWeight = 1000.0;  // What 1 of structure counts; 170 is the spread of the appearance. Lower,
                                             // and lines are erased: 680 lost a tenth of them.
constexpr double kControlUnit = 4.5;  // Found by trial on synthetic crackle, with a share of a half: twice as much
                                      // brings the control error down by a fifth, and breaks more lines.
constexpr int kBlock = 8;             // Texels. Seam costs are kept by block.
constexpr int kSmallestHalf_px = 8, kLargestHalf_px = 44;

/// Where borders cost most.
class BlockCosts {
 public:
  BlockCosts(const SynthesisLevel& level, const TexelNeighborhood& beside, const SeamFeatures& features)
      : level_(level),
        beside_(beside),
        features_(features),
        columns_((level.destination.map->width() + kBlock - 1) / kBlock),
        rows_((level.destination.map->height() + kBlock - 1) / kBlock),
        costs_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0) {}

  [[nodiscard]] std::size_t size() const { return costs_.size(); }
  [[nodiscard]] std::size_t block_of(TexelId t) const {
    const int width = level_.destination.map->width();
    return static_cast<std::size_t>(t / width / kBlock * columns_ + t % width / kBlock);
  }
  /// Of the pairs of the texels in each block.
  void measure(const PlaceMap& places, const RunControl& control) {
    const DestinationLevel& d = level_.destination;
    parallel_for(rows_, 1, control, [&](std::int64_t begin, std::int64_t end) {
      TexelNeighborhood::Cursor cursor(beside_);
      for (std::int64_t row = begin; row < end; ++row) {
        const auto first = costs_.begin() + row * columns_;
        std::fill(first, first + columns_, 0);
        for (int y = static_cast<int>(row) * kBlock;
             y < std::min<int>((static_cast<int>(row) + 1) * kBlock, d.map->height()); ++y) {
          for (int x = 0; x < d.map->width(); ++x) {
            const TexelId t = TexelId{y} * d.map->width() + x;
            if (d.map->is_covered(t)) first[x / kBlock] += texel_cost(t, cursor, places);
          }
        }
      }
    });
  }
  /// Of the 3 x 3 blocks around one.
  [[nodiscard]] std::int64_t around(std::size_t block) const {
    const int x = static_cast<int>(block) % columns_, y = static_cast<int>(block) / columns_;
    std::int64_t sum = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (x + dx >= 0 && x + dx < columns_ && y + dy >= 0 && y + dy < rows_)
          sum += costs_[static_cast<std::size_t>((y + dy) * columns_ + x + dx)];
      }
    }
    return sum;
  }
  /// A covered texel near the middle of a block; -1 = none.
  [[nodiscard]] TexelId texel_in(std::size_t block) const {
    const TexelMap& map = *level_.destination.map;
    const int x0 = static_cast<int>(block) % columns_ * kBlock, y0 = static_cast<int>(block) / columns_ * kBlock;
    TexelId best = -1;
    int least = kBlock * kBlock;
    for (int y = y0; y < std::min(y0 + kBlock, map.height()); ++y) {
      for (int x = x0; x < std::min(x0 + kBlock, map.width()); ++x) {
        const TexelId t = TexelId{y} * map.width() + x;
        const int away = std::abs(x - x0 - kBlock / 2) + std::abs(y - y0 - kBlock / 2);
        if (!map.is_covered(t) || away >= least) continue;
        best = t;
        least = away;
      }
    }
    return best;
  }

 private:
  [[nodiscard]] std::int64_t texel_cost(TexelId t, TexelNeighborhood::Cursor& cursor, const PlaceMap& places) const {
    const DestinationLevel& d = level_.destination;
    const FixedPoint here = places.point(t);
    std::int64_t sum = 0;
    for_each_pair(t, cursor.at(t).subspan(beside_.first_adjacent()), d.map->width(),
                  [&](const PixelNeighbor& n, bool is_earlier, int weight) {
                    if (!is_earlier) sum += weight * features_.seam(here, places.point(n.texel), {n.x, n.y});
                  });
    return sum;
  }

  const SynthesisLevel& level_;
  const TexelNeighborhood& beside_;
  const SeamFeatures& features_;
  int columns_, rows_;
  std::vector<std::int64_t> costs_;
};

/// A window of a round: its patch is found twice, since all patches of a large atlas at once would take more memory
/// than everything else.
struct Window {
  std::size_t block = 0;
  TexelId center = -1;
  int half_px = 0;
  bool has_gained = false;
};

class Refiner {
 public:
  Refiner(const SynthesisLevel& level, const TexelNeighborhood& beside, const CutTask& task, Amounts& amounts,
          double scale_px, std::uint64_t seed, PlaceMap& places)
      : level_(level),
        map_(*level.destination.map),
        beside_(beside),
        task_(task),
        amounts_(amounts),
        seed_(seed),
        places_(places),
        costs_(level, beside, task.features),
        patience_(costs_.size(), kPatient),
        is_taken_(static_cast<std::size_t>(map_.num_texels()), 0),
        finder_(map_, beside) {
    for (double factor : {0.4, 0.6, 0.9, 1.3, 2.0})
      halves_.push_back(std::clamp(static_cast<int>(factor * scale_px), kSmallestHalf_px, kLargestHalf_px));
  }

  void round(int index, const RunControl& control) {
    costs_.measure(places_, control);
    amounts_.measure(level_.destination, places_, control);
    choose_windows(index, control);
    // No window holds a texel beside another's: what one writes, no other reads.
    parallel_for(static_cast<std::int64_t>(windows_.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
      Window& window = windows_[static_cast<std::size_t>(begin)];
      SurfacePatch patch;
      PatchFinder finder(map_, beside_);
      finder.find_texels(window.center, window.half_px, patch);
      finder.find_edges(patch);
      PatchCut cut(task_);
      const RandomStream random(seed_, window.block, 3000 + static_cast<std::uint32_t>(index));
      window.has_gained = cut.improve(patch, places_, random, control) > 0;
      if (!window.has_gained) return;
      for (std::size_t i = 0; i < patch.texels.size(); ++i) places_.set(patch.texels[i].texel, cut.improved()[i]);
    });
    for (int& p : patience_) p += (kPatient - p) / 8;
    for (const Window& window : windows_) {
      int& patience = patience_[window.block];
      patience = patience * (window.has_gained ? 9 : 6) / 10;
    }
  }

 private:
  static constexpr int kPatient = 256;
  static constexpr std::uint8_t kBeside = 1, kMember = 2;  ///< Of a window of this round.

  /// Greedily, those of most cost first, none within a texel of another.
  void choose_windows(int index, const RunControl& control) {
    windows_.clear();
    std::fill(is_taken_.begin(), is_taken_.end(), std::uint8_t{0});
    struct Wish {
      std::int64_t priority;
      std::size_t block;
    };
    std::vector<Wish> wishes;
    for (std::size_t b = 0; b < costs_.size(); ++b) {
      if (const std::int64_t cost = costs_.around(b); cost > 0) wishes.push_back({cost * patience_[b], b});
    }
    std::stable_sort(wishes.begin(), wishes.end(),
                     [](const Wish& a, const Wish& b) { return a.priority > b.priority; });
    SurfacePatch patch;
    for (const Wish& wish : wishes) {
      if (windows_.size() % 16 == 0) control.throw_if_stopped();
      const TexelId center = costs_.texel_in(wish.block);
      if (center < 0 || is_taken_[static_cast<std::size_t>(center)] != 0) continue;
      finder_.find_texels(center, kSmallestHalf_px / 2, patch);  // Most have no room: this is quick.
      if (room_px(patch) < kSmallestHalf_px / 2) continue;
      RandomStream random(seed_, wish.block, 2000 + static_cast<std::uint32_t>(index));
      finder_.find_texels(center, halves_[random.below(static_cast<std::uint32_t>(halves_.size()))], patch);
      const int room = room_px(patch);
      if (room < kSmallestHalf_px / 2) continue;
      if (room < patch.half_px) finder_.find_texels(center, room, patch);
      finder_.find_edges(patch);
      if (sees_a_member(patch)) continue;
      take(patch);
      windows_.push_back({.block = wish.block, .center = center, .half_px = patch.half_px});
    }
  }
  /// To the nearest texel that is taken, or to the rim.
  [[nodiscard]] int room_px(const SurfacePatch& patch) const {
    std::int32_t room = patch.half_px * PixelNeighbor::kOne;
    for (const PatchTexel& t : patch.texels) {
      if (is_taken_[static_cast<std::size_t>(t.texel)] != 0)
        room = std::min(room, std::max(std::abs(t.offset.x), std::abs(t.offset.y)) - 1);
    }
    return room / PixelNeighbor::kOne;
  }
  /// Over seams a texel may see one that does not see it.
  [[nodiscard]] bool sees_a_member(const SurfacePatch& patch) const {
    return std::any_of(patch.edges.begin(), patch.edges.end(), [&](const PatchEdge& e) {
      return e.outside >= 0 && is_taken_[static_cast<std::size_t>(e.outside)] == kMember;
    });
  }
  /// With the texels beside it: they are held fixed.
  void take(const SurfacePatch& patch) {
    for (const PatchEdge& e : patch.edges) {
      if (e.outside >= 0) is_taken_[static_cast<std::size_t>(e.outside)] = kBeside;
    }
    for (const PatchTexel& t : patch.texels) is_taken_[static_cast<std::size_t>(t.texel)] = kMember;
  }

  const SynthesisLevel& level_;
  const TexelMap& map_;
  const TexelNeighborhood& beside_;
  const CutTask& task_;
  Amounts& amounts_;
  std::uint64_t seed_;
  PlaceMap& places_;
  BlockCosts costs_;
  std::vector<int> patience_;  ///< By block: falls where nothing is gained.
  std::vector<std::uint8_t> is_taken_;
  PatchFinder finder_;
  std::vector<int> halves_;
  std::vector<Window> windows_;
};

}  // namespace

void refine_places(const SynthesisLevel& level, const SourceStructure& structure, const SimilarPixels& similar,
                   std::span<const double> control_weights, std::uint64_t seed, const RefinementOptions& options,
                   PlaceMap& places, const RunControl& control) {
  RunControl silent = control;
  silent.on_progress = nullptr;
  const DestinationLevel& destination = level.destination;
  const TexelNeighborhood beside(*destination.map, {}, destination.placement.frames, destination.placement.pixel_mm,
                                 silent);
  const SeamFeatures features(level.source, structure.channels, kStructureWeight * structure.weight);
  const ControlCost control_cost(level.source, control_weights, kControlUnit * options.control_share);
  Amounts amounts(level.source);
  const CutTask task{.source = level.source,
                     .destination = level.destination,
                     .features = features,
                     .control_cost = control_cost,
                     .similar = similar,
                     .amounts = amounts};
  Refiner refiner(level, beside, task, amounts, structure.scale_px, seed, places);
  for (int round = 0; round < options.num_rounds; ++round) {
    refiner.round(round, silent);
    control.report(static_cast<double>(round + 1) / options.num_rounds);
  }
}

}  // namespace patinate::transfer
