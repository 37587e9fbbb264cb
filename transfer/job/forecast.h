/// \file
/// What can be said of a transfer before it is made: how often each part of the source will be seen.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

struct TransferForecast {
  std::int64_t num_usable = 0;  ///< Pixels of the history inside the mask.
  std::int64_t num_pixels = 0;
  int window_px = 0;           ///< Side of the neighborhood that is compared.
  std::int64_t num_whole = 0;  ///< Usable pixels whose whole neighborhood is usable: only these are copied.
  double surface_mm2 = 0.0;    ///< Surface of the mesh.
  double surface_share = 0.0;  ///< The surface's area over that of the usable pixels.
  double num_copies = 0.0;   ///< Copies of each pixel that is asked for, mean over the surface: surface_share, or more
                             ///< where controls ask for some values more often than the source has them.
  double asked_share = 1.0;  ///< Asked share of the usable pixels: those of control values that the surface asks for.
  std::string narrowest;     ///< The control that leaves asked_share.
};
/// From areas, all pixels, and up to 2^18 texels, evenly chosen.
/// @param neighborhood_radius_px  As TransferOptions has it; 0 counts as 3, that of a source without structure.
/// @throws InvalidInput as transfer().
[[nodiscard]] TransferForecast forecast_transfer(const TransferInput& input, int neighborhood_radius_px = 0);

/// A line for each thing that will be seen in the result, with what would help.
[[nodiscard]] std::vector<std::string> warnings_of(const TransferForecast& forecast);

}  // namespace patinate::transfer
