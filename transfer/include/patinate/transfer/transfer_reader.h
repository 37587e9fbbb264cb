/// \file
/// A finished transfer: what it says before any of its pixels are read, and its surface at any time, looked up through
/// its coordinates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/history/history.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/image.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

struct PackedPlaces;

/// The content of `transfer.json`, with the history that it names. Thread-safe.
class TransferFolder {
 public:
  /// @param path  A transfer folder, or its transfer.json. @throws IoError, also when the history has changed since.
  explicit TransferFolder(const std::filesystem::path& path);

  [[nodiscard]] const TransferManifest& manifest() const { return manifest_; }
  [[nodiscard]] const HistoryReader& history() const { return history_; }
  /// How the tiles lie beside each other.
  [[nodiscard]] const Sheet& sheet() const { return sheet_; }
  /// Its mesh in mm, with normals and with the UVs of its tiles. @throws IoError
  [[nodiscard]] AtlasMesh read_atlas() const;

 private:
  TransferManifest manifest_;
  HistoryReader history_;
  Sheet sheet_;
};

/// Value of the source at every texel's coordinates; `outside` where they are -1. Between pixels, that of a cubic
/// through 4 x 4 of them (look_between()). The simple version, and the truth, of gather_packed().
/// @param source       1 to 4 channels.
/// @param coordinates  H x W x 2, places inside the source in pixels, or -1.
[[nodiscard]] ImageF gather(const ImageF& source, const ImageF& coordinates, float outside = 0.0f,
                            const RunControl& control = {});

/// Thread-safe.
class TransferReader {
 public:
  /// Opens a transfer folder (or its transfer.json) and the history that it names, and checks that they belong
  /// together.
  /// @throws IoError, also when the history has changed since.
  explicit TransferReader(const std::filesystem::path& path);

  [[nodiscard]] const TransferManifest& manifest() const { return folder_.manifest(); }
  [[nodiscard]] const HistoryReader& history() const { return folder_.history(); }
  /// In mm, with normals and with UVs over the sheet of all tiles: for TexelMap and renderers.
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  /// In mm, with normals and with the UVs of its tiles, as mesh.obj has them.
  [[nodiscard]] const AtlasMesh& atlas() const { return atlas_; }
  /// How the tiles lie in coordinates() and in what sample() gives.
  [[nodiscard]] const Sheet& sheet() const { return folder_.sheet(); }
  /// H x W x 2, over the sheet.
  [[nodiscard]] const ImageF& coordinates() const { return coordinates_; }
  /// The same as packed_lookup.h has them, gutters filled and borders repeated over the margins tile by tile; made when
  /// first asked for.
  [[nodiscard]] const PackedPlaces& filled_places() const;
  [[nodiscard]] ImageU8 coverage() const;
  /// The control that the transfer was given, over the sheet.
  [[nodiscard]] TransferControl control(std::size_t index) const;
  /// The control that the transfer was asked to follow, over the sheet, H x W x 1, in the values of the history's
  /// control (match_controls()), as edits have painted it. (rest unchanged)
  [[nodiscard]] ImageF matched_control(std::size_t index) const;
  /// The history's pixels that could be copied: its mask and the one that was given (usable_mask()).
  [[nodiscard]] ImageU8 source_mask() const;
  /// The surface's color at a time of the history's unit (clamped to its ends): H x W x 3 over the sheet, linear.
  /// Gutters are filled tile by tile, so that filtering does not bleed. At a frame's time inside the charts exactly
  /// that frame's values.
  [[nodiscard]] ImageF sample(double time, const RunControl& control = {}) const;
  /// The same, an image per tile.
  [[nodiscard]] std::vector<ImageF> sample_tiles(double time, Between between = Between::Blend,
                                                 const RunControl& control = {}) const;
  /// The same with a time for every texel (gather_at_times()). @param times  Over the sheet.
  [[nodiscard]] std::vector<ImageF> sample_tiles(const ImageF& times, Between between,
                                                 const RunControl& control = {}) const;
  /// Samples another map of the frames (sample_material_map()) over the sheet, with filled gutters; normals are in the
  /// tangent space of their texels: x along growing u, y along growing v, z out of the surface. (rest unchanged)
  [[nodiscard]] ImageF sample_map(MaterialMap map, double time, Between between = Between::Blend,
                                  const RunControl& control = {}) const;
  /// Values of any image of the history's size at every texel, over the sheet, gutters filled.
  [[nodiscard]] ImageF gather_sheet(const ImageF& source, const RunControl& control = {}) const;
  /// The tiles of an image over the sheet.
  [[nodiscard]] std::vector<ImageF> tiles_of(ImageF values) const;
  /// Values of any image of the history's size at every texel, an image per tile, gutters filled.
  /// @param source  Height and width of the history, 1 to 4 channels.
  [[nodiscard]] std::vector<ImageF> gather_tiles(const ImageF& source, const RunControl& control = {}) const;

 private:
  void read_coordinates();
  /// How patches lie, filled as filled_places(); empty when coordinates do not say it.
  [[nodiscard]] const Image<std::uint32_t>& filled_turns() const;
  /// An image over the sheet from a file a tile; margins hold `outside`.
  [[nodiscard]] ImageF read_sheet(const std::vector<std::filesystem::path>& files,
                                  const std::vector<std::string>& channels, float outside) const;
  /// The tiles of an image over the sheet, gutters filled.
  [[nodiscard]] std::vector<ImageF> filled_tiles(const ImageF& values) const;

  TransferFolder folder_;
  AtlasMesh atlas_;
  Mesh mesh_;
  ImageF coordinates_;
  mutable std::once_flag filled_once_, turns_once_;
  mutable std::shared_ptr<const PackedPlaces> filled_;
  mutable Image<std::uint32_t> turns_;
};

}  // namespace patinate::transfer
