/// \file
/// From a capture project of kind `relit` to a material history.
#pragma once

#include <filesystem>

#include "capture/project/progress_control.h"
#include "capture/project/relit_project.h"
#include "capture/project/scan_control.h"
#include "capture/stability/fill.h"
#include "libcommon/job/job.h"
#include "patinate/capture/registration.h"
#include "patinate/capture/unlight.h"
#include "patinate/core/options.h"

namespace patinate::capture {

/// Events of every step, for programs; for people it is kIngestPageFile.
inline constexpr const char* kRelitReportFile = "relit.json";

/// How steps' scans find their places: all together in one graph of poses, or each on the reference's.
enum class RelitPoses { Joint, Each };

/// Settings of plan_relit_ingest() that are not facts about the capture.
struct RelitOptions {
  bool accept_failed = false;  ///< Leave steps that cannot be registered out of the history instead of stopping.
  RegistrationOptions registration = {};  ///< Registration of steps without `transform`, from `initial` or as they lie.
  bool heights = false;  ///< Frames have `height`: how much higher the step's scan stands than the reference's, mm.
  RelitPoses poses = RelitPoses::Joint;  ///< Joint needs all scans in memory; a step that is added moves all others.
  UnlightOptions unlight = {};
  ScanOptions scan =
      {};  ///< scale_mm: width of accessibility's Gaussian; not given: 2 % of the reference scan's diagonal.
  FillOptions fill = {};          ///< Texels that some step does not show.
  ProgressOptions progress = {};  ///< For projects without any shape.
};
/// Describes options that `ingest` has not described for captures of the other kind already: accept_failed, the method
/// of registration, unlight.
void describe(OptionVisitor& v, RelitOptions& o);

/// Plan that writes the history of a project into `output`. Items: the reference view; a pose for every step; a frame
/// for every step, each in memory that does not depend on their number. Then the mask, the controls, the report and
/// history.json.
///
/// A step's photographs, less the ambient light and brought to the reference patch's strength, are resampled into the
/// reference view through its scan and pose, and unlighted (unlight()) with the reference's positions and normals moved
/// into its scanner frame and its own scan casting shadows. Frames carry `mask`, `stddev` and `normal`. Albedos of all
/// steps have one scale: that of the lights' strengths, or of the patch where the reference scan shows it. Controls:
/// `accessibility` (1/mm, height_curvature() of the reference scan toward the camera), with maps of position, normal,
/// height and texel size; `progress` when there is no shape. The key covers files by content, numbers of the project
/// and options; a step's own key covers what its frame depends on.
/// @throws InvalidInput if an option is out of range; IoError if a file cannot be read. Running it: CannotComplete when
/// a step cannot be registered and may not be excluded; IoError on photographs that are black or saturated everywhere.
[[nodiscard]] JobPlan plan_relit_ingest(const RelitProject& project, const RelitOptions& options,
                                        const std::filesystem::path& output);

}  // namespace patinate::capture
