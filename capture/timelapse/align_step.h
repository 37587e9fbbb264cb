/// \file
/// The step of an ingest that aligns photographs of any size and rotation with the reference one. Only ingest uses it.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "capture/handheld/photo_graph.h"
#include "capture/project/given_transforms.h"
#include "capture/timelapse/ingest_work.h"
#include "libcommon/job/job.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Where the photographs lie, loaded once.
struct PlaceTable {
  std::mutex mutex;
  bool is_loaded = false;
  std::map<int, Eigen::Matrix3d> reference_from_photo;  ///< By the photograph's number.
  std::once_flag once_reference;
  ImageF reference;  ///< The reference's roi in color, which fills what other photographs do not show.
};

/// Photographs have to be matched: kAlignmentFile is made before all else.
[[nodiscard]] bool needs_alignment(const IngestWork& work);
/// With --accept-failed: aligns at once, or takes what an earlier run found into `output`, and leaves photographs that
/// fit nothing out of the project. @throws CannotComplete if no other photograph fits the reference.
void leave_out_failed(IngestWork& work, const std::filesystem::path& output);
/// Content of all that says where frame `index` lies; "" for photographs of a fixed camera.
[[nodiscard]] std::string place_key(const IngestWork& work, std::size_t index);
/// Adds the item that writes kAlignmentFile, where it is needed. It stops with CannotComplete when a photograph fits
/// nothing, naming it and the `exclude` to paste.
void add_alignment_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work);
/// Adds what the history depends on.
void add_alignment_inputs(JobInputs& inputs, const IngestWork& work);
/// @throws InvalidInput for options that are for fixed cameras only.
void check_handheld_options(const IngestWork& work);

/// Reference from photograph, of a history whose photographs are laid over one another.
[[nodiscard]] Eigen::Matrix3d place_of(const IngestWork& work, int index, const std::filesystem::path& folder);

}  // namespace patinate::capture
