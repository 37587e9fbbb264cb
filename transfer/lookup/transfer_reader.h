/// \file
/// A finished transfer at any time: lookups through its coordinates.
#pragma once

#include <filesystem>

#include "libcommon/geometry/mesh.h"
#include "libcommon/history/history.h"
#include "libcommon/image/image.h"
#include "transfer/transfer_io.h"

namespace patinate {

/// Value of the source at every texel's coordinates; `outside` where they are -1.
/// @param coordinates  H x W x 2, whole numbers inside the source, or -1.
[[nodiscard]] ImageF gather(const ImageF& source, const ImageF& coordinates, float outside = 0.0f, const RunControl& control = {});

/// Thread-safe.
class TransferReader {
 public:
  /// Opens a transfer folder (or its transfer.json) and the history that it names, and checks that they belong together.
  /// @throws IoError, also when the history has changed since.
  explicit TransferReader(const std::filesystem::path& path);

  [[nodiscard]] const TransferManifest& manifest() const { return manifest_; }
  [[nodiscard]] const HistoryReader& history() const { return history_; }
  /// With the UVs that were used, in mm.
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  /// H x W x 2.
  [[nodiscard]] const ImageF& coordinates() const { return coordinates_; }
  [[nodiscard]] ImageU8 coverage() const;
  /// The surface's colour at a time of the history's unit (clamped to its ends): H x W x 3, linear. Gutters are filled, so that
  /// filtering does not bleed. At a frame's time inside the charts exactly that frame's values.
  [[nodiscard]] ImageF sample(double time, const RunControl& control = {}) const;

 private:
  TransferManifest manifest_;
  HistoryReader history_;
  Mesh mesh_;
  ImageF coordinates_;
};

}  // namespace patinate
