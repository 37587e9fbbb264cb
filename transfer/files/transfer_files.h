/// \file
/// What the files of a transfer folder are called, and what transfer.json may say.
#pragma once

#include <cstddef>
#include <string>

#include "patinate/transfer/transfer_io.h"

namespace patinate::transfer {

inline constexpr const char* kSourceMaskFile = "source_mask.png";

[[nodiscard]] UvLayoutRule rule_of(const TransferTask& task);
/// File of a control: relative to the folder, with `<UDIM>` where there are tiles.
[[nodiscard]] std::string control_file(const TransferTask& task, std::size_t index);

/// The JSON Schema of transfer.json.
[[nodiscard]] Json transfer_schema();

}  // namespace patinate::transfer
