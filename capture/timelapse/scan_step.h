/// \file
/// The step of an ingest that looks at a scan under the fixed camera. Inside of ingest only.
#pragma once

#include <memory>
#include <vector>

#include "capture/timelapse/ingest_work.h"
#include "libcommon/job/job.h"

namespace patinate::capture {

/// Control that a scan gives.
inline constexpr const char* kScanControlName = "accessibility";

/// The scan's mesh, repaired, in mm; its content counts into the work's key. @throws IoError (a point cloud, a mesh
/// without area, ...).
void load_scan(IngestWork& work);
/// Item that writes the maps of the history and what the control is made of. Nothing is added without a scan.
void add_scan_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work);
/// Adds what the history depends on.
void add_scan_inputs(JobInputs& inputs, const IngestWork& work);
/// Takes what the camera does not see of the mesh off the mask, which may be empty. @throws IoError if nothing is left.
void keep_scanned(const IngestWork& work, const std::filesystem::path& folder, ImageU8& mask);
/// Names the maps, writes the control, and gives the history its texel size when the project has none.
/// @param mask  Within keep_scanned().
void write_scan(HistoryWriter& writer, const IngestWork& work, const std::filesystem::path& folder,
                const ImageU8& mask);

}  // namespace patinate::capture
