/// \file
/// The whole of ingest in one call: a capture as it lies in a folder becomes a material history.
#pragma once

#include <filesystem>
#include <string>

#include "patinate/core/run_control.h"

namespace patinate::capture {

/// Options of a caller; everything else has the default of `patinate ingest`.
struct MakeHistoryOptions {
  bool stabilize = false;        ///< Lay moved photographs over the first one.
  bool deflicker = false;        ///< Take changes of exposure out.
  std::string flat_field = "";   ///< "" = none, "estimate", "first", or the path of a photograph of a uniform surface.
  bool keep_highlights = false;  ///< Pixels in a highlight stay; otherwise they are masked.
  bool add_progress = false;     ///< Make the `progress` control also beside measured ones.
  bool force = false;            ///< Replace a different history that lies in `output`.
};

/// Makes the folder `output` (a history that HistoryReader opens) from a time-lapse or from scans under lamps. Resumes
/// a run that was ended: what is finished is not done again. A finished history of the same capture and options stays
/// as it is.
/// @param capture  A capture.json, or the folder that holds it (docs/capture.md).
/// @throws IoError if a file cannot be read; InvalidInput if the capture or an option is out of range, or scans under
/// lamps come with stabilize, deflicker, flat_field or keep_highlights; CannotComplete if `output` holds something
/// else; Canceled.
void make_history(const std::filesystem::path& capture, const std::filesystem::path& output,
                  const MakeHistoryOptions& options = {}, const RunControl& control = {});

}  // namespace patinate::capture
