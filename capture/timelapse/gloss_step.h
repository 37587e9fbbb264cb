/// \file
/// The step of an ingest that tells the highlight of one lamp from the color below it. Inside of ingest only.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "capture/gloss/standing_gloss.h"
#include "capture/timelapse/ingest_work.h"

namespace patinate::capture {

/// Figures of every material and time.
inline constexpr const char* kGlossFile = "gloss.json";

/// Result of a series under known lamps.
struct SeriesGloss {
  GlossRig rig = {};
  StandingGloss found = {};

  /// A photograph as the surface is: its light divided out and the highlight taken off. @param color  H x W x 3.
  [[nodiscard]] ImageF albedo(int frame, const ImageF& color) const;
};

/// Nothing without `lights` in the project; finished frames are read, and saturated pixels left out.
/// @param mask  What is inside; may be empty.
[[nodiscard]] std::optional<SeriesGloss> measure_gloss(const IngestWork& work, const std::filesystem::path& folder,
                                                       const ImageU8& mask, const RunControl& control);

/// When frames are masked: lets every frame show its albedo, writes `specular` (with metals `metalness` and `tint`) of
/// each and kGlossFile. What the project's `appearance` states is not written. @returns what is to be warned of.
[[nodiscard]] std::vector<HistoryWarning> write_gloss(HistoryWriter& writer, const IngestWork& work,
                                                      const std::filesystem::path& folder, const SeriesGloss& gloss,
                                                      const RunControl& control);

/// Adds what the history depends on.
void add_gloss_inputs(JobInputs& inputs, const IngestWork& work);

}  // namespace patinate::capture
