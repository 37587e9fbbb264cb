#include <cstdint>
#include <map>

#include "capture/project/sample_facts.h"
#include "capture/timelapse/align_step.h"
#include "capture/timelapse/chart_step.h"
#include "capture/timelapse/gloss_step.h"
#include "capture/timelapse/ingest_work.h"
#include "capture/timelapse/patch_step.h"
#include "capture/timelapse/repair_steps.h"
#include "capture/timelapse/scan_step.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/history/appearance_json.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// Raised whenever the same input gives other output.
constexpr std::int64_t kStageVersion = 4;
/// Version of what a transmission photograph becomes alone.
constexpr std::int64_t kThicknessVersion = 3;
/// Version of the page.
constexpr std::int64_t kPageVersion = 1;

std::string roi_text(const PixelRectangle& roi) {
  return std::to_string(roi.x) + " " + std::to_string(roi.y) + " " + std::to_string(roi.width) + " " +
         std::to_string(roi.height);
}

/// "photos/day07.jpg" for what lies in or below the project's folder.
std::string name_of(const CaptureProject& project, const fs::path& file) {
  const fs::path relative = file.lexically_relative(project.file.parent_path());
  return relative.empty() ? file.string() : relative.string();
}

}  // namespace

std::vector<std::string> ingest_photo_keys(const CaptureProject& project) {
  std::map<fs::path, std::string> movies;  // Hashed once.
  std::vector<std::string> keys;
  for (const CapturePhoto& frame : project.frames) {
    if (!frame.stream) {
      keys.push_back(hash_file(frame.file));
      continue;
    }
    std::string& key = movies[frame.file];
    if (key.empty()) key = hash_file(frame.file);
    keys.push_back(ContentHash().add(key).add(std::int64_t{frame.image}).hex());
  }
  return keys;
}

std::string ingest_frame_key(const IngestWork& work, std::size_t index) {
  const CaptureProject& project = work.project;
  ContentHash hash;
  hash.add("ingest frame").add(kStageVersion).add(work.photo_keys[index]);
  hash.add(project.response.text()).add(roi_text(project.roi)).add(project.scale);
  hash.add(repair_frame_key(work));
  if (project.is_handheld()) hash.add(place_key(work, index));
  if (const std::string gain = gain_key(work, index); !gain.empty()) hash.add(gain);
  return hash.hex();
}

std::string photo_name(const CaptureProject& project, const CapturePhoto& frame) {
  return name_of(project, frame.file) + (frame.stream ? ", image " + std::to_string(frame.image) : std::string());
}

JobInputs ingest_inputs(const IngestWork& work) {
  const CaptureProject& project = work.project;
  // The part that a file plays is in its key: a mask in a control's place is another input.
  const auto file_key = [](const char* part, const fs::path& file) {
    return ContentHash().add(part).add_file(file).hex();
  };
  JobInputs inputs = JobInputs::counted_without_names("ingest");
  inputs.add_value("version of ingest", std::to_string(kStageVersion))
      .add_value("version of report.html", std::to_string(kPageVersion))
      .add_value("name", project.name)
      .add_value("time_unit", time_unit_text(project.time_unit))
      .add_value("texel_size_mm", project.texel_size_mm ? number_text(*project.texel_size_mm) : "null")
      .add_value("response", project.response.text())
      .add_value("roi", roi_text(project.roi))
      .add_value("scale", number_text(project.scale));
  for (std::size_t i = 0; i < project.frames.size(); ++i) {
    const std::string name = photo_name(project, project.frames[i]);
    inputs.add_value(name, work.photo_keys[i]);
    inputs.add_value("time of " + name, number_text(project.frames[i].time));
  }
  if (!project.sample.empty()) inputs.add_value("sample", sample_text(project.sample));
  for (const HistoryWarning& warning : project.time_warnings)
    inputs.add_value("times that disagree", ContentHash().add(warning_text(warning)).hex());
  if (project.mask) inputs.add_value("mask " + name_of(project, *project.mask), file_key("mask", *project.mask));
  for (const GivenControl& c : project.controls) {
    inputs.add_value("control " + c.name, ContentHash().add(c.name).add(c.unit).add_file(c.file).hex());
  }
  if (project.transmission) {
    const TransmissionPhotos& t = *project.transmission;
    inputs.add_value("transmission " + name_of(project, t.photo), file_key("transmission", t.photo));
    if (t.blank) inputs.add_value("blank " + name_of(project, *t.blank), file_key("blank", *t.blank));
    std::string align = t.align == TransmissionPhotos::Align::None ? "none" : "auto";
    if (t.align == TransmissionPhotos::Align::Points) {
      align = "points";
      for (const PointPair& p : t.points) {
        for (double v : {p.in_image.x(), p.in_image.y(), p.in_reference.x(), p.in_reference.y()})
          align += " " + number_text(v);
      }
    }
    inputs.add_value("align", align);
    inputs.add_value("version of thickness", std::to_string(kThicknessVersion));
    inputs.add_options(option_values(work.options.thickness));
  }
  add_scan_inputs(inputs, work);
  if (work.has_progress) {
    inputs.add_value("control progress", "made from the frames");
    inputs.add_options(option_values(work.options.progress));
  }
  if (work.options.background.mask_background != "off") inputs.add_options(option_values(work.options.background));
  if (!project.appearance.is_empty()) inputs.add_value("appearance", appearance_key(project.appearance));
  if (work.options.add_deviations) inputs.add_value("deviations", "made from the frames");
  add_repair_inputs(inputs, work);
  add_alignment_inputs(inputs, work);
  add_patch_inputs(inputs, work);
  add_chart_inputs(inputs, work);
  add_gloss_inputs(inputs, work);
  return inputs;
}

}  // namespace patinate::capture
