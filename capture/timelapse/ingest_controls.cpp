#include <utility>

#include "capture/thickness/thickness_warnings.h"
#include "capture/timelapse/ingest_work.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

void write_given_control(HistoryWriter& writer, const CaptureProject& project, const GivenControl& given,
                         const ImageU8& mask) {
  const ImageF values = to_history_size(read_gray(given.file), project, given.file);
  const Percentiles range = percentiles(values, mask, 0.0, 1.0);
  writer.write_control(given.name, values, static_cast<double>(range.low), static_cast<double>(range.high), given.unit);
}

LayerWindow write_thickness(HistoryWriter& writer, const IngestWork& work, const TransmissionLight& light,
                            const ImageU8& mask, const RunControl& control) {
  try {
    ThicknessOptions options = work.options.thickness;
    options.with_deviation = work.options.add_deviations;
    const ThicknessMap map = thickness_from_transmission(light.photo, light.blank, mask, options, control);
    writer.write_control("thickness", map.values, map.low, map.high, "relative");
    if (!map.deviation.empty()) writer.write_control_deviation(map.deviation);
    const std::string name = work.project.transmission->photo.filename().string();
    for (HistoryWarning& warning : thickness_warnings(map.evidence, name, work.options.thickness))
      writer.add_warning(std::move(warning));
    return map.window;
  } catch (const InvalidInput& e) {
    throw IoError(work.project.transmission->photo.string(), e.what());
  }
}

/// From the frames that the items have written.
void write_progress(HistoryWriter& writer, const IngestWork& work, const fs::path& folder, const ImageU8& mask,
                    const RunControl& control) {
  std::vector<double> times;
  for (const CapturePhoto& frame : work.project.frames) times.push_back(frame.time);
  const auto read_frame = [&](int i) { return read_color(folder / writer.manifest().frames[i].file); };
  FrameDeviations deviations;  // Deviations of photographs from one place: their noise, each pixel by itself.
  if (work.options.add_deviations) {
    deviations.read = [&](int i) {
      return read_channels(folder / HistoryWriter::frame_extra_file(i, "stddev"), frame_extra_channels("stddev"));
    };
  }
  const ProgressMap map = progress_from_history(times, read_frame, mask, work.options.progress, control, deviations);
  writer.write_control(kProgressName, map.values, map.low, map.high, "relative");
  if (!map.deviation.empty()) writer.write_control_deviation(map.deviation);
}

}  // namespace

std::optional<LayerWindow> write_ingest_controls(HistoryWriter& writer, const IngestWork& work,
                                                 const TransmissionLight& transmission, const fs::path& folder,
                                                 const ImageU8& mask, const RunControl& control) {
  std::optional<LayerWindow> window;
  for (const GivenControl& given : work.project.controls) write_given_control(writer, work.project, given, mask);
  if (work.project.transmission) window = write_thickness(writer, work, transmission, mask, control.part(0.0, 0.25));
  if (work.has_progress) write_progress(writer, work, folder, mask, control.part(0.25, 1.0));
  return window;
}

}  // namespace patinate::capture
