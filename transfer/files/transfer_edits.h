/// \file
/// Edits of a finished transfer: an ordered list that is kept as a file, and gives the same bytes whenever it is
/// applied.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/json.h"
#include "transfer/guidance/painted_control.h"

namespace patinate::transfer {

enum class EditKind {
  Stroke,  ///< Paints a control; what lies under the brush is searched again.
  Refine   ///< Refines the borders of copied pieces wherever was painted since the last time.
};
inline constexpr std::array<std::string_view, 2> kEditKindNames{"stroke", "refine"};

struct TransferEdit {
  EditKind kind = EditKind::Stroke;
  std::string control;  ///< Of the history, one that the transfer follows. It and what follows: of a stroke.
  double value = 0.0;   ///< [0, 1]. In the history's values: 0 and 1 are its least and greatest.
  BrushStroke stroke;   ///< In mm, on mesh.obj of the transfer.
};

/// The content of a file of edits.
struct TransferEdits {
  std::vector<TransferEdit> edits;  ///< In the order in which they are applied.
};

inline constexpr const char* kEditsFile = "edits.json";  ///< In the folder of an edited transfer.
inline constexpr const char* kEditsFormat = "patinate.edits";

/// @throws IoError
[[nodiscard]] TransferEdits read_transfer_edits(const std::filesystem::path& file);
/// As read_transfer_edits(), of what stands in a file. @param file  For messages.
[[nodiscard]] TransferEdits edits_from_json(const Json& json, const std::filesystem::path& file);
void write_transfer_edits(const std::filesystem::path& file, const TransferEdits& edits);
/// Of the file.
[[nodiscard]] Json edits_json(const TransferEdits& edits);
/// @param edits  All of a transfer. @param controls  Of the history, that the transfer follows.
/// @throws InvalidInput naming the first edit, from 1, of another control, or that refines where nothing was painted
void check_edits(const TransferEdits& edits, std::span<const std::string> controls);
[[nodiscard]] Json edits_schema();

}  // namespace patinate::transfer
