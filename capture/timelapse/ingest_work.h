/// \file
/// What the steps of an ingest share. Inside of ingest only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/project/capture_project.h"
#include "capture/timelapse/ingest.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history.h"

namespace patinate::capture {

/// Name of the control that progress_from_history() makes.
inline constexpr const char* kProgressName = "progress";

struct RepairTables;
struct PlaceTable;
struct GainTable;
struct ColorTable;

struct IngestWork {
  CaptureProject project;
  IngestOptions options;
  std::vector<std::string> photo_keys;  ///< Content of every frame's photograph.
  std::string key;
  bool has_progress = false;
  std::shared_ptr<RepairTables> repairs = nullptr;        ///< repair_steps.h; shared by the frames of one run.
  std::shared_ptr<PlaceTable> places = nullptr;           ///< align_step.h; likewise.
  std::shared_ptr<GainTable> gains = nullptr;             ///< patch_step.h; likewise.
  std::shared_ptr<ColorTable> colors = nullptr;           ///< chart_step.h; likewise.
  std::shared_ptr<const Json> known_alignment = nullptr;  ///< leave_out_failed().
  std::shared_ptr<const Mesh> scan_mesh = nullptr;        ///< load_scan(); in mm.
  std::string scan_key = "";                              ///< Its content.
  std::vector<std::string> chart_photo_keys = {};         ///< Content of photographs of a chart alone.

  /// The history without frames and controls.
  [[nodiscard]] HistoryManifest manifest() const;
};

/// Number of pixels of all photographs, as they were taken.
[[nodiscard]] inline double num_photo_pixels(const CaptureProject& project) {
  return static_cast<double>(project.photo_width) * project.photo_height * static_cast<double>(project.frames.size());
}

struct PixelSize {
  int width, height;
};
/// Size of a history whose longer side is reduced to `longest` pixels, if it has more; 1 or more either way.
[[nodiscard]] PixelSize reduced_size(const CaptureProject& project, int longest);

/// Content of every frame's image. @throws IoError
[[nodiscard]] std::vector<std::string> ingest_photo_keys(const CaptureProject& project);
/// Key of what frame `index` depends on.
[[nodiscard]] std::string ingest_frame_key(const IngestWork& work, std::size_t index);
/// Name of a photograph among the inputs.
[[nodiscard]] std::string photo_name(const CaptureProject& project, const CapturePhoto& frame);
/// Everything that the history depends on, by name.
[[nodiscard]] JobInputs ingest_inputs(const IngestWork& work);
/// Transmission as the history shows it.
struct TransmissionLight {
  ImageF photo;     ///< H x W x 1, linear; empty when the project has none.
  ImageF blank;     ///< H x W x 1; may be empty.
  ImageU8 reached;  ///< 0 where a photograph from another pose does not reach; empty when it reaches everywhere.
};
/// Reads the transmission photographs and brings them into the frames' view; an alignment is written to
/// `folder / kTransmissionFile`. @throws IoError naming the photograph, and what to give, when it cannot be aligned.
[[nodiscard]] TransmissionLight read_transmission_light(const IngestWork& work, const std::filesystem::path& folder,
                                                        const RunControl& control);
/// Writes every control of the history in `folder`, whose frames are finished.
/// @param mask  What is inside; may be empty. @returns the window of the thickness, where there is one.
std::optional<LayerWindow> write_ingest_controls(HistoryWriter& writer, const IngestWork& work,
                                                 const TransmissionLight& transmission,
                                                 const std::filesystem::path& folder, const ImageU8& mask,
                                                 const RunControl& control);

}  // namespace patinate::capture
