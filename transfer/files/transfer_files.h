/// \file
/// What the files of a transfer folder are called, and what transfer.json may say.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libcommon/atlas/texel_set.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

inline constexpr const char* kSourceMaskFile = "source_mask.png";

[[nodiscard]] UvLayoutRule rule_of(const TransferTask& task);
/// File of a control: relative to the folder, with `<UDIM>` where there are tiles.
[[nodiscard]] std::string control_file(const TransferTask& task, std::size_t index);

/// All options that a transfer was made with. @param path  Its folder, or its transfer.json. @throws IoError
[[nodiscard]] TransferOptions read_used_options(const std::filesystem::path& path);

/// Texels of a transfer that lie elsewhere now.
struct EditedPlaces {
  TexelSet texels;
  const TexelMap& map;                    ///< Over the sheet of all tiles.
  const FlowFrames* frames = nullptr;     ///< As read_flow() gives them; null: the files say no angles.
  const std::vector<LibraryPart>& parts;  ///< Of a library; else empty.
  int source_width = 0;                   ///< Of the history, pixels.
  std::function<SourcePlace(TexelId t)> place_of;
};
/// Changes those texels in the coordinates of a transfer folder, and nothing else.
void rewrite_coordinates(const TransferManifest& manifest, const EditedPlaces& edited, const RunControl& run = {});
/// transfer.json of a transfer that was edited: its energy, and that kEditsFile lies beside it.
void rewrite_transfer_manifest(const std::filesystem::path& folder, const EnergyReport& energy);

/// The JSON Schema of transfer.json.
[[nodiscard]] Json transfer_schema();

}  // namespace patinate::transfer
