/// \file
/// A transfer whose texels no process holds, as pictures show it: its color at a lower resolution.
#pragma once

#include <cstdint>
#include <memory>

#include "patinate/atlas/sheet.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/transfer/transfer_reader.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::app {

/// Tiles reduced by the smallest whole number with which all of them together have at most `most` texels.
[[nodiscard]] Sheet reduced_sheet(const Sheet& sheet, std::int64_t most);

/// Thread-safe.
class ReducedTransfer {
 public:
  /// @param most  Texels of the reduced sheet. Reads and checks all coordinates.
  ReducedTransfer(std::shared_ptr<const transfer::TransferFolder> transfer, std::int64_t most,
                  const RunControl& control = {});

  [[nodiscard]] const Sheet& sheet() const { return sheet_; }
  /// Over sheet(), linear: the mean of the 8-bit codes' light over what a texel stands for, gutters of the finest
  /// texels filled; borders repeated over the margins. A tile is gone through in strips.
  [[nodiscard]] ImageF sample(double time, const RunControl& control = {}) const;

 private:
  std::shared_ptr<const transfer::TransferFolder> transfer_;
  Sheet sheet_;
  transfer::TextureWriter textures_;
};

}  // namespace patinate::app
