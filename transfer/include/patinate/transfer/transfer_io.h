/// \file
/// The transfer folder: `transfer.json` and the files beside it.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "patinate/image/image.h"
#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

inline constexpr const char* kCoordinateChannels[2] = {"source.x", "source.y"};
inline constexpr const char* kIndexChannel =
    "source.index";  ///< Of a library: which of its histories; -1 outside the charts.

/// The history's own content key, or one made of its files when it has none.
[[nodiscard]] std::string history_content_key(const HistoryReader& history);

/// H x W x 2 source coordinates in pixels, whole numbers in their middles, -1 outside.
[[nodiscard]] ImageF coordinate_image(const TransferResult& result, int width, int height, int source_width);

/// Pixels along the side of what lookups show in a texel, to a hundredth; 1: one pixel. @param pixel_mm  Of the
/// history.
[[nodiscard]] double footprint_px(const TexelMap& map, double pixel_mm, Footprint footprint);

/// Members `energy`, `coherence`, `control_error_mean` ...
[[nodiscard]] Json energy_json(const EnergyReport& energy);

/// Everything that a transfer folder is made from.
struct TransferTask {
  std::shared_ptr<const HistoryReader> history;
  TransferInput input;  ///< Of that history, whatever `history` says here; the map lies over the sheet of all tiles.
  TransferOptions options;
  std::shared_ptr<const AtlasMesh>
      atlas;                        ///< The same mesh with the UVs of its tiles, in mm; none: the map's, one square.
  std::string mesh_name;            ///< For provenance: the file's name.
  std::optional<std::string> unit;  ///< The mesh file's unit when it was said.
  double mm_per_mesh_unit = 1.0;
  bool is_history_installed = false;  ///< It stays where it is when the transfer is moved.
  std::string flow = "uv";            ///< What the frames were made from, for people.
  std::string source_mask_name;       ///< For people: the file's name.
};

/// One square of the atlas.
struct TransferTile {
  std::string name;  ///< "1001", a material's name; "" for a square alone.
  std::filesystem::path coordinates;
  std::vector<std::string> controls = {};  ///< Their files, relative to the folder; empty for a square alone.
};

/// A control pair as `transfer.json` keeps it.
struct RecordedControl {
  std::string source;       ///< Control of the history.
  std::string destination;  ///< As the user asked for it.
  double weight = 1.0;
  ControlMapping mapping = ControlMapping::Rank;
  ControlRange range;          ///< Of the destination's values.
  std::filesystem::path file;  ///< The destination's values; tile_path() of it for every tile.

  [[nodiscard]] std::string text() const { return source + "=" + destination; }
};

/// The content of `transfer.json`.
struct TransferManifest {
  std::filesystem::path history;  ///< Absolute or relative to the working folder.
  std::string history_name, history_key;
  int history_width = 0, history_height = 0;
  std::filesystem::path mesh;
  std::string made_from;  ///< Name of the mesh file that was given.
  std::string mesh_key;
  UvLayoutRule tile_rule = UvLayoutRule::Square;
  std::vector<TransferTile> tiles;  ///< At least one.
  bool is_unwrapped = false;        ///< The UVs were made for this transfer.
  int width = 0;                    ///< Of a tile.
  int height = 0;
  double texel_size_mm = 1.0;  ///< Surface length of one pixel of the history.
  double footprint_px = 1.0;   ///< Pixels along the side of what lookups average for a texel (mean_over_footprint()).
  bool is_subpixel = false;    ///< Coordinates lie between pixels, too.
  std::string flow = "uv";     ///< What the history's direction on the surface was made from.
  std::vector<RecordedControl> controls;
  std::optional<std::filesystem::path> source_mask;  ///< What may be copied, beside the history's own mask.
  std::optional<std::filesystem::path> edits;        ///< Edits that were applied afterwards.
  std::optional<std::string> unit;
  double mm_per_mesh_unit = 1.0;
  EnergyReport energy;
  std::optional<StructureFacts> structure;
  double refused_line_share = 0.0;  ///< TransferResult's.
  TransferOptions measured_with;    ///< Coherence share, neighborhood and appearance of that energy, and whether pieces
                                    ///< are turned; what an earlier version did not write is as it was then.
  std::int64_t covered_texels = 0;
  std::int64_t seed = 0;
  double explained_variance = 0.0;  ///< TransferResult's.
  std::string key;
  /// The tiles in one grid, as TexelMap sees them.
  [[nodiscard]] Sheet sheet() const;
};
/// @param path  A transfer folder, or its transfer.json. @throws IoError
[[nodiscard]] TransferManifest read_transfer_manifest(const std::filesystem::path& path);

/// Writes coordinates, controls (a file a tile), mesh and source mask into an existing folder.
void write_transfer_files(const std::filesystem::path& folder, const TransferTask& task, const TransferResult& result,
                          const RunControl& run = {});
/// Writes transfer.json. @param final_folder  Where the folder will stand: the history's path is written relative to
/// it.
void write_transfer_manifest(const std::filesystem::path& folder, const std::filesystem::path& final_folder,
                             const TransferTask& task, const TransferResult& result, const std::string& key);

}  // namespace patinate::transfer
