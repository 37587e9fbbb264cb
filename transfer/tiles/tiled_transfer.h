/// \file
/// A transfer in pieces that hold a tile of the atlas each, and give what the transfer in one piece gives.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "patinate/controls/control_kinds.h"
#include "patinate/core/run_control.h"
#include "patinate/transfer/transfer_io.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/tile_grid.h"

namespace patinate::transfer {

/// What is transferred by tile.
struct TiledTask {
  /// Its map is unsearched(), and its controls have no values: they are made tile by tile.
  TransferTask transfer;
  ControlKindOptions kinds;
};

/// The pieces, in the order in which they need one another; those of one kind need not wait for each other. All read
/// what earlier ones wrote below kJobWorkFolder of `folder`. The coordinates are, to the bit, those of transfer().
class TiledTransfer {
 public:
  /// @throws InvalidInput naming what cannot be done by tile.
  explicit TiledTransfer(TiledTask task);
  ~TiledTransfer();

  [[nodiscard]] const TileGrid& grid() const { return grid_; }
  [[nodiscard]] const TiledTask& task() const { return task_; }
  /// Levels [0, this) are worked on by tile.
  [[nodiscard]] std::size_t num_tiled_levels() const { return grid_.num_tiled_levels(); }
  [[nodiscard]] int num_passes(std::size_t level) const;

  using Folder = std::filesystem::path;
  /// 1. Counts texels, and makes the controls: also the tile's control maps.
  void survey(int tile, const Folder& folder, const RunControl& control);
  /// 2. The controls in the history's values; on every tiled level who looks over seams, and what lies near others.
  void match(int tile, const Folder& folder, const RunControl& control);
  /// 3. Controls of levels [1, num_tiled_levels()], one after the other.
  void halve(std::size_t level, int tile, const Folder& folder, const RunControl& control);
  /// 4. All coarser levels.
  void synthesize_coarse(const Folder& folder, const RunControl& control);
  /// 5. From the coarsest tiled level to the finest: places from the coarser level, then passes and rounds.
  void start(std::size_t level, int tile, const Folder& folder, const RunControl& control);
  void pass(std::size_t level, int pass, int tile, const Folder& folder, const RunControl& control);
  /// The rounds of refinement after the passes of a level: 0 where the source has no structure that it may show. A
  /// level turns out not to show it once texels are counted: then a round leaves everything as it is.
  [[nodiscard]] int num_rounds(std::size_t level) const;
  /// Each round first over borders: the zones of the tile with higher ones. Then the tile itself.
  void refine_borders(std::size_t level, int round, int tile, const Folder& folder, const RunControl& control);
  void refine(std::size_t level, int round, int tile, const Folder& folder, const RunControl& control);
  /// 6. Figures, and the tile's coordinates.
  void finish(int tile, const Folder& folder, const RunControl& control);
  /// 7. What remains: mesh and manifest. @param final_folder  As write_transfer_manifest()'s.
  void join(const Folder& folder, const Folder& final_folder, const std::string& key, const RunControl& control);

 private:
  struct Prepared;
  const Prepared& prepare(const Folder& folder, const RunControl& control);
  struct LoadedLevel;
  void write_borders(std::size_t level, int tile, const Folder& folder, const RunControl& control);

  TiledTask task_;
  TileGrid grid_;
  SourceStructure structure_;
  std::size_t num_refined_levels_ = 0;  ///< At most.
  std::mutex mutex_;
  std::unique_ptr<const Prepared> prepared_;  ///< What all pieces from the third on need.
};

}  // namespace patinate::transfer
