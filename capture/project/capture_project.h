/// \file
/// A capture project (`patinate.capture`, docs/capture.md): which photographs make a history, and when they were taken.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/alignment/alignment.h"
#include "capture/project/align_settings.h"
#include "capture/project/capture_rig.h"
#include "capture/project/chart_settings.h"
#include "capture/project/frame_sources.h"
#include "libcommon/history/appearance.h"
#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/history/history.h"
#include "patinate/image/color.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Photographs on a back-light.
struct TransmissionPhotos {
  /// How they lie over the frames: taken from the same pose, or to be found by what both show, or by points that are
  /// given.
  enum class Align { None, Auto, Points };
  std::filesystem::path photo;
  std::optional<std::filesystem::path> blank;  ///< The back-light without the layer, from the pose of `photo`.
  Align align = Align::None;
  std::vector<PointPair> points;  ///< For Points: four or more, in `photo` and in the frames.
};

/// A control map that was measured elsewhere.
struct GivenControl {
  std::string name;
  std::filesystem::path file;  ///< One channel, as large as the photographs or as the history.
  std::string unit;
};

/// Part of the photographs, in their pixels.
struct PixelRectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// Geometry under the fixed camera.
struct ScanSource {
  std::filesystem::path mesh;
  double mm_per_unit = 1.0;  ///< Mm per unit of the mesh and of the camera's translation: the project's `unit`.
  Camera camera_mm;          ///< Camera of the photographs, before roi and scale; in a world of mm.
};

/// `kind: "fixed"`: a fixed camera under constant light. Every path is usable as it stands.
struct CaptureProject {
  std::filesystem::path file;  ///< The project file itself.
  std::string name;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::string time_source;  ///< Source of times as FrameSources says it.
  std::string time_span;
  std::vector<HistoryWarning> time_warnings;
  Response response;  ///< Response of codes; camera RAW and float images are light already.
  bool has_raw_frames = false;
  std::vector<CapturePhoto> frames;  ///< Strictly increasing time; excluded ones are excluded.
  std::vector<int> excluded;         ///< Their numbers, as `exclude` has them; rising.
  AlignSettings align;               ///< Alignment of photographs that no fixed camera took.
  int reference = 0;                 ///< The frame whose pixels all others are laid over.
  int photo_width = 0;               ///< Size of every photograph; where they are laid over one, of that one.
  int photo_height = 0;
  PixelRectangle roi;  ///< Inside the photographs; all of them when none is given.
  double scale = 1.0;  ///< (0, 1]; applied after the roi.
  std::optional<TransmissionPhotos> transmission;
  std::optional<ScanSource> scan;
  std::optional<CaptureRig> rig;  ///< Where lamp and camera stood; then the highlight is told from the albedo.
  std::vector<GivenControl> controls;
  Appearance appearance;  ///< Stated material beside its color; may be empty.
  std::optional<std::filesystem::path> mask;
  std::string background = "off";                 ///< What is masked beside it, as background_rule() reads it.
  std::optional<PixelRectangle> reference_patch;  ///< Patch of the reference photograph: its color does not change.
  std::optional<ChartSettings> chart;             ///< Colors are measured by it.
  std::optional<double> texel_size_mm;            ///< Surface length of a pixel of the photographs.

  /// Size of the history: the roi times scale, rounded, at least 1.
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// Photographs are laid over the reference one: they are aligned, or transforms are given.
  [[nodiscard]] bool is_handheld() const;
  std::vector<SampleFact> sample = {};
};

/// Reads and checks a project: every file is there, is an image, and has the right size; pixels are not decoded.
/// @param align,chart  What the command line says of aligning and of a chart, over what the project says.
/// @throws IoError / InvalidInput naming the file and what is wrong.
[[nodiscard]] CaptureProject read_capture_project(const std::filesystem::path& file, const AlignOptions& align = {},
                                                  const ChartOptions& chart = {});

/// Cuts the roi out and scales it (area averages). An image of the history's size is taken as it is.
/// @param image  As large as the photographs or the history. @throws IoError naming `file` if it is neither.
[[nodiscard]] ImageF to_history_size(const ImageF& image, const CaptureProject& project,
                                     const std::filesystem::path& file);
/// Pixels of a photograph that are not as its file has them.
struct ClippedPixels {
  std::int64_t num_outside = 0;  ///< Pixels of a color outside of Rec. 709; what was negative is 0.
  std::int64_t num_beyond = 0;   ///< Brighter than half floats hold; 65504 now.
};
/// Whether read_whole_photo() may clip it.
[[nodiscard]] bool may_be_clipped(const CaptureProject& project, const CapturePhoto& photo);
/// A frame's photograph in linear color, before roi and scale. @param clipped  Is added to; null = not asked for.
/// @throws IoError
[[nodiscard]] ImageF read_whole_photo(const CaptureProject& project, const CapturePhoto& photo,
                                      ClippedPixels* clipped = nullptr);

/// Where saturation shows.
struct SaturationPhoto {
  ImageF photo;
  float level = 0.0f;  ///< From which on a channel is saturated: code 254 of 255; the largest half for float images.
};
/// @param color  read_whole_photo()'s. Other primaries hide it: of such a photograph its codes as they are.
[[nodiscard]] SaturationPhoto saturation_photo(const CaptureProject& project, const CapturePhoto& photo,
                                               const ImageF& color);
/// A frame as the history shows it: linear color, roi, scale. @throws IoError
[[nodiscard]] ImageF read_photo(const CaptureProject& project, const CapturePhoto& photo);
/// Reads a photograph that is no frame. @throws IoError
[[nodiscard]] ImageF read_photo(const CaptureProject& project, const std::filesystem::path& file);
/// Pixels that all frames show: the given mask without what is transparent in any frame; empty when everything is
/// inside.
/// @throws IoError naming the file if nothing is left.
[[nodiscard]] ImageU8 read_capture_mask(const CaptureProject& project, const RunControl& control = {});

/// The capture.json in a folder, or the file itself.
[[nodiscard]] std::filesystem::path capture_file(const std::filesystem::path& path);

}  // namespace patinate::capture
