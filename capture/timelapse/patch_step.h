/// \file
/// The step of an ingest that keeps the color of a patch that does not age, and what EXIF says of the exposure before
/// it. Inside of ingest only.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "capture/timelapse/ingest_work.h"
#include "libcommon/job/job.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// Result of the patch, kept in the history's work; every photograph's factors.
inline constexpr const char* kPatchFile = "survey/patch.json";

/// Factors by the photograph's number, loaded once.
struct GainTable {
  std::mutex mutex;
  bool is_loaded = false;
  std::map<int, std::array<double, 3>> gains;
};

/// Adds the item that measures the patch, where the project names one: after the photographs are aligned.
///
/// In every photograph the mean linear light of the patch's pixels, without the tenths that are brightest and darkest;
/// the factors bring it to the reference photograph's. A photograph that shows under a quarter of the patch, or more
/// than a tenth of it saturated, has no factors of its own.
void add_patch_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work);
/// Content of all that the light of frame `index` is changed by, a chart included; "" where its light is left as it is.
[[nodiscard]] std::string gain_key(const IngestWork& work, std::size_t index);
void add_patch_inputs(JobInputs& inputs, const IngestWork& work);

/// Factors of a frame's linear light: by the patch; else, of a hand-held series with linear response, the exposure by
/// EXIF against the reference photograph's; else 1.
[[nodiscard]] std::array<double, 3> light_gain(const IngestWork& work, int index, const std::filesystem::path& folder);
/// The exposure by EXIF is divided out of a photograph.
[[nodiscard]] bool divides_exif_exposure(const IngestWork& work);

/// Completes survey.json by `reference_patch` and says what is to be warned of: photographs whose patch is not seen, or
/// whose factors do not fit all of it.
[[nodiscard]] std::vector<HistoryWarning> report_patch(const IngestWork& work, const std::filesystem::path& folder);

}  // namespace patinate::capture
