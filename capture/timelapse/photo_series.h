/// \file
/// What of a project's photographs aligns them. Inside of ingest only.
#pragma once

#include "capture/handheld/align_series.h"
#include "capture/timelapse/ingest_work.h"

namespace patinate::capture {

/// Photographs are read when they are asked for; for markers at once. @param work  Outlives it. @throws IoError,
/// CannotComplete
[[nodiscard]] PhotoSeries photo_series(const IngestWork& work, const RunControl& control);

}  // namespace patinate::capture
