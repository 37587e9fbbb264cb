#include "capture/timelapse/gloss_step.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/relit/material_frame.h"
#include "capture/timelapse/repair_steps.h"
#include "capture/unlighting/material_maps.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/light_io.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr float kMaxHalf = 65504.0f;

Vec3 vector_at(const ImageF& image, int x, int y) {
  return {static_cast<double>(image.at(x, y, 0)), static_cast<double>(image.at(x, y, 1)),
          static_cast<double>(image.at(x, y, 2))};
}

/// Positions and normals of a flat plate.
void lay_plate(const CaptureProject& project, GlossRig& rig) {
  const int width = project.width(), height = project.height();
  const double mm = *project.texel_size_mm;
  rig.position_mm = ImageF(width, height, 3);
  rig.normal = ImageF(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double px = project.roi.x + (x + 0.5) * project.roi.width / width - 0.5,
                   py = project.roi.y + (y + 0.5) * project.roi.height / height - 0.5;
      rig.position_mm.at(x, y, 0) = static_cast<float>(mm * (px - 0.5 * (project.photo_width - 1)));
      rig.position_mm.at(x, y, 1) = static_cast<float>(mm * (0.5 * (project.photo_height - 1) - py));
      rig.normal.at(x, y, 2) = 1.0f;
    }
  }
}

GlossRig rig_of(const IngestWork& work, const fs::path& folder, const ImageU8& mask) {
  const CaptureProject& project = work.project;
  GlossRig rig{.mask = mask, .lights = project.rig->lights, .cameras = project.rig->cameras};
  if (project.scan) {
    rig.position_mm = read_channels(folder / HistoryWriter::map_file("position"), {"X", "Y", "Z"});
    rig.normal = read_channels(folder / HistoryWriter::map_file("normal"), {"X", "Y", "Z"});
    rig.cameras = {project.scan->camera_mm.center()};
  } else {
    lay_plate(project, rig);
  }
  if (!rig.lights.front().is_intensity_known) normalize_exposure(rig, static_cast<int>(project.frames.size()));
  return rig;
}

bool is_stated(const IngestWork& work, const char* name) {
  const std::vector<std::string> names = work.project.appearance.map_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Result in unlighting's form, from which the one model of a frame is made.
UnlightResult result_of(const GlossFrame& frame, const GlossRig& rig, int index) {
  const int width = frame.albedo.width(), height = frame.albedo.height();
  UnlightResult out{
      .albedo = frame.albedo, .specular = ImageF(width, height, 2), .mask = ImageU8(width, height, 1, 255)};
  out.reflectance = ImageF(width, height, 3);
  out.metalness = ImageF(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto roughness = static_cast<double>(frame.roughness.at(x, y));
      out.specular.at(x, y, 1) = frame.roughness.at(x, y);
      if (!(roughness > 0.0)) continue;
      const GlossPixel pixel = gloss_pixel(rig, index, x, y);
      const double facing = pixel.is_lit ? pixel.normal.dot(pixel.to_camera) : 1.0;
      const Vec3 strength = vector_at(frame.strength, x, y), albedo = vector_at(frame.albedo, x, y);
      Vec3 f0;
      for (int c = 0; c < 3; ++c) f0[c] = f0_of_strength(strength[c], roughness, facing);
      for (int c = 0; c < 3; ++c) out.reflectance.at(x, y, c) = static_cast<float>(f0[c]);
      out.metalness.at(x, y) = static_cast<float>(std::min(1.0, static_cast<double>(frame.metallic.at(x, y))) *
                                                  metal_share(albedo.mean(), f0.mean()));
    }
  }
  return out;
}

Json gloss_json(const IngestWork& work, const StandingGloss& found) {
  Json json{{"format", "patinate.gloss"},
            {"version", 1},
            {"nearest_deg", found.nearest_deg},
            {"farthest_deg", found.farthest_deg},
            {"materials", Json::array()}};
  if (!found.refusal.empty()) json["refusal"] = found.refusal;
  for (const GlossMaterial& m : found.materials) {
    Json entry{
        {"share", m.share}, {"saved", m.course.saved}, {"is_told", m.course.is_told}, {"is_metallic", m.is_metallic}};
    if (m.course.is_told) {
      entry["tint"] = {m.course.tint[0], m.course.tint[1], m.course.tint[2]};
      for (std::size_t t = 0; t < m.course.at.size(); ++t) {
        const LobeAt& at = m.course.at[t];
        const double f0 = f0_of_strength(at.strength, at.roughness, 1.0);
        entry["at"].push_back({{"time", work.project.frames[t].time},
                               {"roughness", at.roughness},
                               {"roughness_deviation", at.roughness * at.roughness_deviation},
                               {"f0", f0},
                               {"f0_deviation", f0 * at.strength_deviation}});
      }
    }
    json["materials"].push_back(std::move(entry));
  }
  return json;
}

std::vector<HistoryWarning> gloss_warnings(const IngestWork& work, const StandingGloss& found) {
  std::vector<HistoryWarning> warnings;
  const auto warn = [&](std::string text, std::string cure) {
    warnings.push_back({.about = WarningSubject::Light, .text = std::move(text), .cure = std::move(cure)});
  };
  const std::string cure = "state roughness and reflectance (`appearance`), or move the lamp";
  if (!found.refusal.empty())
    warn("the gloss cannot be measured, so the stated gloss is kept: " + found.refusal, cure);
  else if (!found.is_any_told())
    warn("no highlight detected; the surface is matte, or the stated gloss is kept", cure);
  else if (is_stated(work, "specular"))
    warn("the highlight was removed from the color, but the history keeps the gloss that `appearance` states",
         "remove `roughness` and `specular` from `appearance` to use the measured gloss");
  if (found.is_any_told() && !work.project.rig->lights.front().is_intensity_known)
    warn("the lamp has no `intensity`, so that albedo and F0 are known only up to a common factor",
         "give an `intensity`, from `calibrate` or a white card");
  return warnings;
}

}  // namespace

ImageF SeriesGloss::albedo(int frame, const ImageF& color) const {
  return take_gloss_off(rig, frame, color, found, {}).albedo;
}

std::optional<SeriesGloss> measure_gloss(const IngestWork& work, const fs::path& folder, const ImageU8& mask,
                                         const RunControl& control) {
  if (!work.project.rig) return std::nullopt;
  SeriesGloss gloss{.rig = rig_of(work, folder, mask)};
  std::vector<double> times;
  for (const CapturePhoto& frame : work.project.frames) times.push_back(frame.time);
  const auto read_photo = [&](int i) {
    GlossPhoto photo{.color = read_color(folder / HistoryWriter::frame_file(i))};
    if (!has_validity(work)) return photo;
    photo.valid = read_validity(folder, i);
    for (std::uint8_t& v : photo.valid.values()) v = v == static_cast<std::uint8_t>(Validity::Valid) ? 255 : 0;
    return photo;
  };
  gloss.found = find_standing_gloss(gloss.rig, times, read_photo, control);
  return gloss;
}

std::vector<HistoryWarning> write_gloss(HistoryWriter& writer, const IngestWork& work, const fs::path& folder,
                                        const SeriesGloss& gloss, const RunControl& control) {
  const bool has_gloss = gloss.found.is_any_told(), is_written = has_gloss && !is_stated(work, "specular"),
             has_metal = is_written && gloss.found.is_any_metallic() && !is_stated(work, "metalness") &&
                         !is_stated(work, "tint");
  const auto num_frames = static_cast<std::int64_t>(work.project.frames.size());
  parallel_for(num_frames, 1, control, [&](std::int64_t begin, std::int64_t) {
    const int i = static_cast<int>(begin);
    const GlossFrame frame =
        take_gloss_off(gloss.rig, i, read_color(folder / HistoryWriter::frame_file(i)), gloss.found, {});
    const UnlightResult result = result_of(frame, gloss.rig, i);
    MaterialFrame material = material_frame(result);
    // A frame that masking has filled already has its albedo.
    const fs::path filled = folder / HistoryWriter::filled_frame_file(i);
    const bool is_filled = writer.manifest().frames[i].file == HistoryWriter::filled_frame_file(i);
    ImageF color = has_metal ? std::move(material.color) : frame.albedo;
    if (is_filled && !has_metal) color = read_color(filled);
    for (float& v : color.values()) v = std::clamp(v, 0.0f, kMaxHalf);
    fs::create_directories(filled.parent_path());
    write_exr(filled, color, {"R", "G", "B"}, ExrDepth::Half);
    if (is_written) HistoryWriter::write_frame_extra(folder, i, "specular", material.specular);
    if (has_metal) {
      HistoryWriter::write_frame_extra(folder, i, "metalness", result.metalness);
      HistoryWriter::write_frame_extra(folder, i, "tint", material.tint);
    }
  });
  for (int i = 0; i < static_cast<int>(num_frames); ++i) {
    writer.add_filled_frame(i);
    if (is_written) writer.add_written_frame_extra(i, "specular");
    if (has_metal) {
      writer.add_written_frame_extra(i, "metalness");
      writer.add_written_frame_extra(i, "tint");
    }
  }
  save_json(folder / kGlossFile, gloss_json(work, gloss.found));
  return gloss_warnings(work, gloss.found);
}

void add_gloss_inputs(JobInputs& inputs, const IngestWork& work) {
  constexpr std::int64_t kGlossVersion = 1;
  if (!work.project.rig) return;
  const CaptureRig& rig = *work.project.rig;
  ContentHash key;
  key.add("gloss").add(kGlossVersion).add(json_of(rig.lights).dump());
  for (const Vec3& camera : rig.cameras)
    for (int c = 0; c < 3; ++c) key.add(camera[c]);
  inputs.add_value("lights and camera", key.hex());
}

}  // namespace patinate::capture
