/// \file
/// The whole of transfer in one call, without files: a mesh that has the ages of a history.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/history/history_sampling.h"
#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

class TransferReader;

struct AgeOptions {
  int resolution = 1024;                  ///< [16, 16384]. Texels along each side of a tile.
  AtlasMethod atlas = AtlasMethod::Auto;  ///< The mesh's UVs, or new ones where they will not do.
  std::optional<double> mm_per_unit =
      {};  ///< Of the mesh; > 0. Not given: scaled so that one texel equals one pixel of the history.
  std::optional<double> texel_size_mm =
      {};  ///< Surface length of one pixel of the history; > 0. Not given: what the history says.
  DirectionKind flow = DirectionKind::Gravity;  ///< Which way the history's photographs lie on the surface.
  ControlKindOptions controls = {};             ///< Of the kinds that the controls name.
  TransferOptions transfer = {};
  std::shared_ptr<const SearchDevice> device = nullptr;  ///< Not described; as TransferInput's.
};
/// Describes the options that make a surface of a mesh: the first four.
void describe_surface(OptionVisitor& v, AgeOptions& o);
/// All of it.
void describe(OptionVisitor& v, AgeOptions& o);

/// A mesh made ready to be aged.
struct AgingSurface {
  std::shared_ptr<const AtlasMesh> atlas;  ///< In mm, with the UVs of its tiles.
  std::shared_ptr<const TexelMap> map;     ///< The same over the sheet of all tiles.
  double texel_size_mm = 1.0;              ///< Surface length of one pixel of the history.
  double mm_per_mesh_unit = 1.0;
  std::string name = "mesh";             ///< For people: the file that the mesh came from.
  std::optional<std::string> unit = {};  ///< Of that file, when it was said: um, mm, cm or m.
};
/// Repaired (repair_mesh()), with normals, scaled to mm and laid out.
/// @param history  That it will show: its texel size counts unless the options say one. None: as of unknown size.
/// @throws InvalidInput if the mesh cannot be textured or an option is out of range.
[[nodiscard]] AgingSurface make_aging_surface(Mesh mesh, const AgeOptions& options, const HistoryFacts* history,
                                              const RunControl& run = {});

struct SaveOptions {
  bool force = false;                 ///< Replace a different transfer that lies there.
  bool is_history_installed = false;  ///< Name the history by its absolute path: it stays when the folder is moved.
};

/// A mesh with the source of each texel's color at all times. age_surface() makes it. If it was read from a transfer
/// folder, members from `controls` on keep their defaults, except `folder`.
struct AgedMesh {
  Mesh mesh;           ///< In mm, with UVs over the whole texture.
  ImageF coordinates;  ///< H x W x 2: places in the history in pixels; -1 outside the charts.
  ImageU8 coverage;    ///< H x W: 0 / 255.
  EnergyReport energy;
  std::shared_ptr<const History> history;  ///< The history that the coordinates refer to.
  std::shared_ptr<const History>
      shown;  ///< The same history, averaged as the texels show it if they cover several pixels.
  AgingSurface surface = {};
  std::vector<TransferControl> controls = {};  ///< In the order they were given.
  TransferOptions used = {};  ///< Options that were used, with a value for each one that was left open.
  std::shared_ptr<const FlowFrames> frames = nullptr;  ///< How the history lies on the surface; none: as UVs run.
  ZeroedVector<std::int16_t> turns =
      {};                      ///< Rotation of each texel's piece relative to `frames` (SourcePlace); empty: 0.
  TransferOptions asked = {};  ///< Options as the caller gave them.
  DirectionKind flow = DirectionKind::Uv;  ///< What the frames were made from.
  double explained_variance = 0.0;         ///< These three as TransferResult has them.
  std::optional<StructureFacts> structure = {};
  double refused_line_share = 0.0;
  std::shared_ptr<const TransferReader> folder = nullptr;  ///< The folder it was read from, if any.

  /// How the tiles lie in the images.
  [[nodiscard]] const Sheet& sheet() const;
  /// The texture at a time of the history's unit (clamped to its ends): H x W x 3, linear, gutters filled.
  [[nodiscard]] ImageF texture(double time, Between between = Between::Blend, const RunControl& control = {}) const;
  /// The same with a time for every texel (gather_at_times()). @param times  H x W.
  [[nodiscard]] ImageF texture(const ImageF& times, Between between, const RunControl& control = {}) const;
  /// What the history's frames hold beside color, on the surface (TransferReader::sample_map()).
  /// @throws InvalidInput as sample_material_map().
  [[nodiscard]] ImageF material_map(MaterialMap map, double time, Between between = Between::Blend,
                                    const RunControl& control = {}) const;
  /// Values of any image of the history's size at every texel, over the sheet, gutters filled.
  [[nodiscard]] ImageF gather_sheet(const ImageF& source, const RunControl& control = {}) const;
  /// Writes the folder that `patinate transfer` makes of the same input, byte for byte but for run.json. It appears
  /// when it is whole.
  /// @throws InvalidInput if the history lies in memory only, or it was read from a folder; CannotComplete if something
  /// else lies there or it cannot be written; Canceled
  void save(const std::filesystem::path& path, const SaveOptions& options = {}, const RunControl& run = {}) const;
};

/// Reads a transfer folder. @param path  The folder, or its transfer.json. @throws IoError, also if the history has
/// changed since.
[[nodiscard]] AgedMesh read_aged_mesh(const std::filesystem::path& path);

/// @param mesh  Any that read_mesh() gives.
/// @param control  `[SOURCE=]DESTINATION[:weight[:mapping]]`, as --control: "accessibility", "thickness=0.7*facing +
/// 0.3*spray".
/// @throws ParseError if the control cannot be read; InvalidInput if the mesh cannot be textured or an option is out of
/// range; IoError.
[[nodiscard]] AgedMesh age_mesh(const std::shared_ptr<const History>& history, Mesh mesh, std::string_view control,
                                const AgeOptions& options = {}, const RunControl& run = {});

/// Transfers along the given control pairs: the last step of age_mesh(), for your own surfaces and control maps. @param
/// controls  As make_transfer_control() gives them; at least one.
[[nodiscard]] AgedMesh age_surface(const std::shared_ptr<const History>& history, const AgingSurface& surface,
                                   std::vector<TransferControl> controls, const AgeOptions& options = {},
                                   const RunControl& run = {});

/// A control pair of `[SOURCE=]DESTINATION[:weight[:mapping]]` for a surface. @throws as age_mesh().
[[nodiscard]] TransferControl make_control_pair(const History& history, std::string_view control, const TexelMap& map,
                                                const ControlKindOptions& options = {}, const RunControl& run = {});

}  // namespace patinate::transfer
