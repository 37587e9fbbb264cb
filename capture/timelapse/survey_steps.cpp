#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/stability/stabilize.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kSurveyVersion = 2;
constexpr int kDeflickerVersion = 2;  ///< Raised whenever the same photographs give other factors.
constexpr int kChunk = 16;            ///< Frames that one item looks at; the first is their anchor.

fs::path chunk_file(int chunk) { return "survey/pairs-" + zero_padded(static_cast<std::uint64_t>(chunk), 4) + ".json"; }

int num_frames_of(const IngestWork& work) { return static_cast<int>(work.project.frames.size()); }

ImageF read_roi(const IngestWork& work, int index) {
  const PixelRectangle& roi = work.project.roi;
  return crop(read_whole_photo(work.project, work.project.frames[static_cast<std::size_t>(index)]), roi.x, roi.y,
              roi.width, roi.height);
}

/// Compares the frames of a chunk with the ones before, and, when they are to be stabilized, with anchors.
Json survey_chunk(const IngestWork& work, int chunk, const RunControl& control) {
  const int begin = chunk * kChunk, end = std::min(num_frames_of(work), begin + kChunk);
  const bool is_stabilized = work.options.repair.stabilize;
  RunControl quiet = control;
  quiet.on_progress = {};
  const auto prepare = [&](int i) {
    control.throw_if_stopped();
    return prepare_frame(read_roi(work, i), quiet);
  };
  Json pairs = Json::array();
  const auto compare = [&](int a, const PreparedFrame& first, int b, const PreparedFrame& second) {
    pairs.push_back(pair_to_json(compare_frames(a, first, b, second, is_stabilized)));
  };
  const PreparedFrame anchor = prepare(begin);
  if (begin > 0) compare(begin - 1, prepare(begin - 1), begin, anchor);
  if (begin > 1 && is_stabilized) compare(begin - kChunk, prepare(begin - kChunk), begin, anchor);
  PreparedFrame before = anchor;
  for (int i = begin + 1; i < end; ++i) {
    PreparedFrame now = prepare(i);
    compare(i - 1, before, i, now);
    if (is_stabilized && i > begin + 1) compare(begin, anchor, i, now);
    before = std::move(now);
    control.report(static_cast<double>(i - begin) / (end - begin));
  }
  return pairs;
}

JobItem chunk_item(const std::shared_ptr<const IngestWork>& work, int chunk) {
  const int begin = chunk * kChunk, end = std::min(num_frames_of(*work), begin + kChunk);
  const PixelRectangle& roi = work->project.roi;
  ContentHash key;
  key.add("ingest survey")
      .add(kSurveyVersion)
      .add(std::int64_t{begin})
      .add(std::int64_t{work->options.repair.stabilize});
  key.add(work->project.response.text());
  for (int v : {roi.x, roi.y, roi.width, roi.height}) key.add(std::int64_t{v});
  for (int i = std::max(0, begin - kChunk); i < end; ++i) key.add(work->photo_keys[static_cast<std::size_t>(i)]);
  const fs::path file = chunk_file(chunk);
  return {.name = "survey-" + file.stem().string(),
          .outputs = {file},
          .run =
              [work, chunk, file](const fs::path& folder, const RunControl& control) {
                save_json(folder / file, survey_chunk(*work, chunk, control));
                control.report(1.0);
              },
          .key = key.hex(),
          .stage = ingest_stages(*work).survey};
}

std::vector<FramePair> read_pairs(const IngestWork& work, const fs::path& folder) {
  std::vector<FramePair> pairs;
  for (int chunk = 0; chunk * kChunk < num_frames_of(work); ++chunk) {
    const fs::path file = folder / chunk_file(chunk);
    const Json json = load_json(file);
    for (const JsonReader& pair : JsonReader(file.string(), json).elements()) pairs.push_back(pair_from_json(pair));
  }
  return pairs;
}

void save_survey(const IngestWork& work, const fs::path& folder) {
  const RepairOptions& options = work.options.repair;
  const CaptureProject& project = work.project;
  const std::vector<FramePair> pairs = read_pairs(work, folder);
  std::vector<FramePair> neighbors;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(neighbors),
               [](const FramePair& p) { return p.frame == p.reference + 1; });
  Json json{{"format", "patinate.survey"},
            {"version", 2},
            {"stabilized", options.stabilize},
            {"deflickered", options.deflicker}};
  json["findings"] = Json::array();
  for (const FrameFinding& finding : judge_frames(neighbors, project.roi.width, project.roi.height, options.survey)) {
    Json entry = finding_to_json(finding);
    const CapturePhoto& photo = project.frames[static_cast<std::size_t>(finding.frame)];
    entry["photo"] = photo.file.filename().string();
    entry["time"] = photo.time;
    entry["is_shifted"] = finding.is_shifted;
    json["findings"].push_back(std::move(entry));
  }
  if (options.stabilize) {
    const StabilizedMotions motions = solve_motions(num_frames_of(work), pairs, project.roi.width, project.roi.height);
    json["stabilize_residual_px"] = motions.residual_px;
    json["unlinked_frames"] = motions.unlinked_frames;
    json["motions"] = Json::array();
    for (const Eigen::Affine2d& m : motions.frame_from_first) {
      json["motions"].push_back({m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2)});
    }
  }
  if (options.deflicker) {
    std::vector<std::array<double, 3>> gains;
    std::vector<bool> is_known;
    for (const FramePair& pair : neighbors) {
      gains.push_back(pair.change.light.log_gain);
      is_known.push_back(pair.change.light.is_sure());
    }
    json["factors"] = deflicker_factors(gains, options.deflicker_options, is_known);
  }
  json["pairs"] = Json::array();
  for (const FramePair& pair : neighbors) json["pairs"].push_back(pair_to_json(pair));
  save_json(folder / kSurveyFile, json);
}

ImageF make_flat_field(const IngestWork& work, const RunControl& control) {
  const RepairOptions& options = work.options.repair;
  const CaptureProject& project = work.project;
  if (options.flat_field == "estimate") {
    // The roi only: what lies around the surface says nothing about the lamp.
    return estimate_flat_field(
        num_frames_of(work), [&](int i) { return read_roi(work, i); }, options.flat_field_options, control);
  }
  const ImageF light = read_color(options.flat_field, project.response);
  if (light.width() != project.photo_width || light.height() != project.photo_height) {
    throw IoError(options.flat_field, "is " + std::to_string(light.width()) + " x " + std::to_string(light.height()) +
                                          " pixels; a photograph of a uniform surface must be as large as the frames");
  }
  const PixelRectangle& roi = project.roi;
  try {
    return flat_field_from_image(crop(light, roi.x, roi.y, roi.width, roi.height), options.flat_field_options, control);
  } catch (const InvalidInput& e) {
    throw IoError(options.flat_field, e.what());
  }
}

std::string all_photos_key(const IngestWork& work) {
  ContentHash hash;
  for (const std::string& key : work.photo_keys) hash.add(key);
  return hash.hex();
}

std::string flat_field_key(const IngestWork& work) {
  const RepairOptions& options = work.options.repair;
  ContentHash hash;
  hash.add("flat field").add(options.flat_field == "estimate" ? all_photos_key(work) : hash_file(options.flat_field));
  for (const auto& [name, value] : option_values(options.flat_field_options)) hash.add(name).add(value);
  return hash.hex();
}

}  // namespace

IngestStages ingest_stages(const IngestWork& work) {
  const RepairOptions& options = work.options.repair;
  const bool is_repaired = options.stabilize || options.deflicker || !options.flat_field.empty();
  return is_repaired ? IngestStages{.frames = 2, .survey = 0, .decisions = 1}
                     : IngestStages{.frames = 0, .survey = 1, .decisions = 2};
}

void add_survey_items(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work) {
  if (num_frames_of(*work) > 1) {
    for (int chunk = 0; chunk * kChunk < num_frames_of(*work); ++chunk) items.push_back(chunk_item(work, chunk));
    items.push_back({.name = "survey",
                     .outputs = {kSurveyFile},
                     .run =
                         [work](const fs::path& folder, const RunControl& control) {
                           save_survey(*work, folder);
                           control.report(1.0);
                         },
                     .stage = ingest_stages(*work).decisions});
  }
  if (work->options.repair.flat_field.empty()) return;
  items.push_back({.name = "flat-field",
                   .outputs = {kFlatFieldFile},
                   .run =
                       [work](const fs::path& folder, const RunControl& control) {
                         const ImageF gain = make_flat_field(*work, control);
                         ImageF rgb(gain.width(), gain.height(), 3);
                         for (std::int64_t i = 0; i < rgb.num_pixels(); ++i) {
                           for (int c = 0; c < 3; ++c)
                             rgb.data()[3 * i + c] = gain.data()[gain.channels() == 1 ? i : 3 * i + c];
                         }
                         write_exr(folder / kFlatFieldFile, rgb, {"R", "G", "B"}, ExrDepth::Float);
                         control.report(1.0);
                       },
                   .stage = ingest_stages(*work).decisions});
}

std::string repair_frame_key(const IngestWork& work) {
  const RepairOptions& options = work.options.repair;
  ContentHash hash;
  bool is_any = false;
  const auto add = [&](const char* name, const std::string& value) {
    hash.add(name).add(value);
    is_any = true;
  };
  if (options.stabilize) add("stabilize", all_photos_key(work));
  if (options.deflicker)
    add("deflicker", all_photos_key(work) + std::to_string(options.deflicker_options.half_width) + " " +
                         std::to_string(kDeflickerVersion));
  if (!options.flat_field.empty()) add("flat field", flat_field_key(work));
  if (options.highlights == HighlightRule::Mask)
    add("saturated", std::to_string(options.highlight_options.width_share));
  return is_any ? hash.hex() : "";
}

void add_repair_inputs(JobInputs& inputs, const IngestWork& work) {
  const RepairOptions& options = work.options.repair;
  for (const auto& [name, value] : option_values(options)) {
    inputs.add_value(dashed(name), name == "flat_field" && !value.empty() ? flat_field_key(work) : value);
  }
}

}  // namespace patinate::capture
