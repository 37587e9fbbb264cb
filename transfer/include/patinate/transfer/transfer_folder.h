/// \file
/// A finished transfer before any of its pixels are read.
#pragma once

#include <filesystem>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/sheet.h"
#include "patinate/history/history.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

/// What `transfer.json` says, with the history that it names. Thread-safe.
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

/// Of the mesh's numbers, for glTF: a mesh whose unit nobody said keeps the numbers of its file.
[[nodiscard]] inline double meters_per_unit(const TransferManifest& manifest) {
  return manifest.unit ? 0.001 : 1.0 / manifest.mm_per_mesh_unit;
}

}  // namespace patinate::transfer
