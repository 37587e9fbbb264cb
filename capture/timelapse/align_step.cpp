#include "capture/timelapse/align_step.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/handheld/lay_photo.h"
#include "capture/timelapse/ingest_warnings.h"
#include "capture/timelapse/photo_series.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kAlignVersion = 2;  ///< Raised whenever the same photographs give other transforms.

/// For progress: core seconds by details, of all pixels of all photographs (six of 768 x 600, 16 of 512 x 400).
double align_weight(const CaptureProject& project) { return 0.05 + 1.8e-6 * num_photo_pixels(project); }

Json numbers_json(const Eigen::Matrix3d& h) {
  Json numbers = Json::array();
  for (Eigen::Index r = 0; r < 3; ++r) {
    for (Eigen::Index c = 0; c < 3; ++c) numbers.push_back(h(r, c));
  }
  return numbers;
}

std::string alignment_key(const IngestWork& work) {
  const CaptureProject& project = work.project;
  if (work.known_alignment != nullptr) return work.known_alignment->at("key").get<std::string>();
  ContentHash hash;
  hash.add("align photographs").add(kAlignVersion).add(align_method_text(project.align.method));
  hash.add(align_model_text(project.align.model)).add(std::int64_t{project.reference}).add(project.response.text());
  for (std::size_t i = 0; i < work.photo_keys.size(); ++i) {
    hash.add(work.photo_keys[i]);
    if (const auto& transform = project.frames[i].transform) hash.add(numbers_json(*transform).dump());
  }
  if (project.align.landmarks) hash.add_file(*project.align.landmarks);
  if (project.mask) hash.add_file(*project.mask);
  if (project.align.method == AlignMethod::Outline || project.align.method == AlignMethod::Auto)
    hash.add(work.options.background.mask_background);
  return hash.hex();
}

/// Share of the reference's frame (of its roi) that a photograph shows.
double shown_share(const CaptureProject& project, const CapturePhoto& photo, const Eigen::Matrix3d& place) {
  constexpr int kSteps = 64;  // Samples along each side.
  const Eigen::Matrix3d photo_from_reference = place.inverse();
  int num_shown = 0;
  for (int k = 0; k < kSteps * kSteps; ++k) {
    const Eigen::Vector3d at(project.roi.x + (k % kSteps + 0.5) / kSteps * project.roi.width - 0.5,
                             project.roi.y + (k / kSteps + 0.5) / kSteps * project.roi.height - 0.5, 1.0);
    const Eigen::Vector3d p = photo_from_reference * at;
    const Eigen::Vector2d q = p.hnormalized();
    num_shown +=
        p.z() > 0.0 && q.x() >= -0.5 && q.y() >= -0.5 && q.x() <= photo.width - 0.5 && q.y() <= photo.height - 0.5;
  }
  return static_cast<double>(num_shown) / (kSteps * kSteps);
}

Json place_json(const CaptureProject& project, const std::vector<std::string>& names, const PhotoPlace& place,
                std::size_t index) {
  const CapturePhoto& photo = project.frames[index];
  Json json{{"photo", names[index]},
            {"number", photo.number},
            {"time", photo.time},
            {"status", place_status_text(place.status)},
            {"pairs", place.num_pairs}};
  if (place.status == PlaceStatus::Failed) return json;
  json["transform"] = numbers_json(place.reference_from_photo);
  json["model"] = align_model_text(place.model);
  json["residual_px"] = place.residual_px;
  json["pixels_per_reference_pixel"] = fineness(place.reference_from_photo, photo.width, photo.height);
  json["shown_share"] = shown_share(project, photo, place.reference_from_photo);
  if (place.through >= 0) json["through"] = names[place.through];
  return json;
}

Json alignment_json(const IngestWork& work, const SeriesAlignment& alignment) {
  const CaptureProject& project = work.project;
  const std::vector<std::string> names = photo_names(project.frames);
  Json json{{"format", "patinate.alignment"},
            {"version", 1},
            {"key", alignment_key(work)},
            {"method", align_method_text(project.align.method)},
            {"reference", names[project.reference]},
            {"photos", Json::array()},
            {"pairs", Json::array()}};
  for (std::size_t i = 0; i < alignment.places.size(); ++i)
    json["photos"].push_back(place_json(project, names, alignment.places[i], i));
  for (const PhotoPair& pair : alignment.pairs) {
    json["pairs"].push_back({{"photos", {names[pair.a], names[pair.b]}},
                             {"accepted", pair.is_accepted},
                             {"matches", pair.num_matches},
                             {"agreeing", pair.num_agreeing}});
  }
  return json;
}

/// Not the one that was it and not one that failed; of the others the one that most pairs hold.
std::string other_reference(const CaptureProject& project, const std::vector<std::string>& names,
                            const std::vector<PhotoPlace>& places) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (static_cast<int>(i) == project.reference || places[i].status == PlaceStatus::Failed) continue;
    if (!best || places[i].num_pairs > places[*best].num_pairs) best = i;
  }
  return best ? names[*best] : names[project.reference == 0 ? names.size() - 1 : 0];
}

std::string cure_text(const CaptureProject& project, bool is_one, const std::string& other) {
  const std::string them = is_one ? "it" : "them", transform = "give " + std::string(is_one ? "its" : "their");
  const std::string click = "`patinate studio " + project.file.string() + "` to click them";
  std::string cure = "mark points in " + them + " (" + click +
                     ", or `landmarks`: a table with lines of photo,point,x,y), " + transform + " `transform`";
  switch (project.align.method) {
    case AlignMethod::Landmarks:
      cure = "mark at least two points (four for a homography) in each that other photographs show too (" + click + ")";
      break;
    case AlignMethod::Outline:
      cure =
          "an outline needs a plain background or alpha (or --mask-background '#rrggbb', the background's color), all "
          "of the object in the picture, and a shape that is not round or regular; else " +
          cure;
      break;
    case AlignMethod::Markers:
      cure = "each needs whole, sharp markers far apart, or a large one, that others show too; else " + cure;
      break;
    case AlignMethod::Off:
    case AlignMethod::Auto:
    case AlignMethod::Features:
      break;
  }
  return cure + ", another reference (--align-to " + other + ")";
}

/// @throws CannotComplete naming the photographs that fit nothing.
void check_all_placed(const IngestWork& work, const std::vector<PhotoPlace>& places) {
  const CaptureProject& project = work.project;
  std::vector<int> excluded = project.excluded;
  std::vector<std::string> failed;
  const std::vector<std::string> names = photo_names(project.frames);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].status != PlaceStatus::Failed) continue;
    failed.push_back(names[i]);
    excluded.push_back(project.frames[i].number);
  }
  if (failed.empty()) return;
  const std::string start = project.file.string() + ": --align " + align_method_text(project.align.method) + ": ";
  const std::string cure = cure_text(project, failed.size() == 1, other_reference(project, names, places));
  if (failed.size() + 1 >= names.size()) {
    throw CannotComplete(start + "none of the " + std::to_string(names.size()) +
                         " photographs can be aligned with the reference, " + names[project.reference] +
                         "; photographs of one side of one object are needed: " + cure);
  }
  std::sort(excluded.begin(), excluded.end());
  std::string list;
  for (int number : excluded) list += (list.empty() ? "" : ", ") + std::to_string(number);
  throw CannotComplete(start + std::to_string(failed.size()) + " of " + std::to_string(names.size()) +
                       " photographs cannot be aligned with the others (" + photo_list(failed) + "): " + cure +
                       ", or leave " + (failed.size() == 1 ? "it" : "them") + " out: \"exclude\": [" + list +
                       "] in capture.json, or --accept-failed");
}

/// With the light and the camera's place that are its own.
void leave_out(CaptureProject& project, int number) {
  const auto found = std::find_if(project.frames.begin(), project.frames.end(),
                                  [&](const CapturePhoto& p) { return p.number == number; });
  if (found == project.frames.end()) return;
  const auto at = found - project.frames.begin();
  project.frames.erase(found);
  if (!project.rig) return;
  CaptureRig& rig = *project.rig;
  if (rig.lights.size() > 1) rig.lights.erase(rig.lights.begin() + at);
  if (rig.cameras.size() > 1) rig.cameras.erase(rig.cameras.begin() + at);
}

}  // namespace

void leave_out_failed(IngestWork& work, const fs::path& output) {
  if (!work.options.accept_failed || !needs_alignment(work)) return;
  const std::string key = alignment_key(work);
  Json json;
  std::error_code error;
  if (fs::is_regular_file(output / kAlignmentFile, error)) json = load_json(output / kAlignmentFile);
  if (!json.is_object() || json.value("key", "") != key) {
    const SeriesAlignment alignment = align_series(photo_series(work, {}), {});
    const auto is_placed = [](const PhotoPlace& place) { return place.status != PlaceStatus::Failed; };
    if (std::count_if(alignment.places.begin(), alignment.places.end(), is_placed) < 2)
      check_all_placed(work, alignment.places);
    json = alignment_json(work, alignment);
  }
  CaptureProject& project = work.project;
  const int reference_number = project.frames[project.reference].number;
  for (const Json& photo : json.at("photos")) {
    if (photo.contains("transform")) continue;
    const int number = photo.at("number").get<int>();
    project.excluded.push_back(number);
    leave_out(project, number);
  }
  std::sort(project.excluded.begin(), project.excluded.end());
  project.reference = 0;
  while (project.frames[project.reference].number != reference_number) ++project.reference;
  work.known_alignment = std::make_shared<const Json>(std::move(json));
}

bool needs_alignment(const IngestWork& work) {
  return work.project.align.method != AlignMethod::Off && work.project.frames.size() > 1;
}

std::string place_key(const IngestWork& work, std::size_t index) {
  const CaptureProject& project = work.project;
  if (!project.is_handheld()) return "";
  const std::string canvas = size_text(project.photo_width, project.photo_height) + " ";
  if (needs_alignment(work)) return canvas + alignment_key(work);
  const auto& transform = project.frames[index].transform;
  return canvas + (transform ? numbers_json(*transform).dump() : "as it lies");
}

void add_alignment_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work) {
  if (!needs_alignment(*work)) return;
  items.push_back({.name = "align",
                   .outputs = {kAlignmentFile},
                   .run =
                       [work](const fs::path& folder, const RunControl& control) {
                         if (work->known_alignment != nullptr) {
                           save_json(folder / kAlignmentFile, *work->known_alignment);
                           control.report(1.0);
                           return;
                         }
                         const SeriesAlignment alignment =
                             align_series(photo_series(*work, control.part(0.0, 0.1)), control.part(0.1, 1.0));
                         check_all_placed(*work, alignment.places);
                         save_json(folder / kAlignmentFile, alignment_json(*work, alignment));
                       },
                   .key = alignment_key(*work),
                   .stage = 0,
                   .weight = align_weight(work->project)});
}

void add_alignment_inputs(JobInputs& inputs, const IngestWork& work) {
  if (!work.project.is_handheld()) return;
  if (needs_alignment(work)) {
    inputs.add_value("photographs laid over one another", alignment_key(work));
    inputs.add_value("--accept-failed", work.options.accept_failed ? "true" : "false");
  }
  for (std::size_t i = 0; i < work.project.frames.size() && !needs_alignment(work); ++i)
    inputs.add_value("transform of " + work.project.frames[i].name() + " " + std::to_string(i), place_key(work, i));
}

void check_handheld_options(const IngestWork& work) {
  if (work.project.reference_patch && work.options.repair.deflicker)
    throw InvalidInput(work.project.file.string() +
                       ": --deflicker guesses what `reference_patch` measures; leave one of the two out");
  if (work.project.align.method == AlignMethod::Outline && work.project.align.model == AlignModel::Homography) {
    throw InvalidInput(work.project.file.string() +
                       ": an outline shows shift, turn and scale, not a tilt; leave `align_model` out, or align by "
                       "features, markers or landmarks");
  }
  if (!work.project.is_handheld()) return;
  const RepairOptions& options = work.options.repair;
  const std::string file = work.project.file.string();
  if (options.stabilize)
    throw InvalidInput(file +
                       ": --stabilize is for small motion of photographs; `align` or `transform` has "
                       "aligned these already; leave one of the two out");
  if (!options.flat_field.empty() && options.flat_field != "estimate")
    throw InvalidInput(
        file +
        ": --flat-field IMAGE and first need a camera that stands still; photographs that are aligned with each "
        "other (`align`, `transform`) each have a fall-off of their own");
}

Eigen::Matrix3d place_of(const IngestWork& work, int index, const fs::path& folder) {
  const auto& frames = work.project.frames;
  const auto& given = frames[index].transform;
  if (!needs_alignment(work)) return given.value_or(Eigen::Matrix3d::Identity());
  PlaceTable& table = *work.places;
  const std::lock_guard lock(table.mutex);
  if (!table.is_loaded) {
    const Json json = load_json(folder / kAlignmentFile);
    JsonReader reader((folder / kAlignmentFile).string(), json);
    for (JsonReader& photo : reader.member("photos").elements()) {
      if (photo.has("transform"))
        table.reference_from_photo[static_cast<int>(photo.member("number").integer())] =
            read_transform(photo.member("transform"));
    }
    table.is_loaded = true;
  }
  return table.reference_from_photo.at(frames[index].number);
}

}  // namespace patinate::capture
