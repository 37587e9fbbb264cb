#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "capture/stability/frame_order.h"
#include "capture/stability/odd_frames.h"
#include "capture/stability/stabilize.h"
#include "capture/timelapse/align_step.h"
#include "capture/timelapse/frame_photo.h"
#include "capture/timelapse/patch_step.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kSurveyVersion = 6;
constexpr int kDeflickerVersion = 3;  ///< Raised whenever the same photographs give other factors.
using LinkTest = std::function<bool(const FramePair&)>;
constexpr int kChunk = 16;  ///< Frames that one item looks at; the first is their anchor.

fs::path chunk_file(int chunk) { return "survey/pairs-" + zero_padded(static_cast<std::uint64_t>(chunk), 4) + ".json"; }

int num_frames_of(const IngestWork& work) { return static_cast<int>(work.project.frames.size()); }

/// Compares the frames of a chunk with the ones before, and, when they are to be stabilized, with anchors; with how
/// each looks.
Json survey_chunk(const IngestWork& work, int chunk, const fs::path& folder, const RunControl& control) {
  const int begin = chunk * kChunk, end = std::min(num_frames_of(work), begin + kChunk);
  const bool is_stabilized = work.options.repair.stabilize;
  const RunControl quiet = control.silent();
  const auto prepare = [&](int i) {
    control.throw_if_stopped();
    return prepare_frame(read_frame_roi(work, i, folder), quiet);
  };
  Json pairs = Json::array(), looks = Json::array();
  const auto compare = [&](int a, const PreparedFrame& first, int b, const PreparedFrame& second) {
    pairs.push_back(pair_to_json(compare_frames(a, first, b, second, is_stabilized)));
  };
  const PreparedFrame anchor = prepare(begin);
  looks.push_back(look_to_json(frame_look(anchor)));
  if (begin > 0) compare(begin - 1, prepare(begin - 1), begin, anchor);
  if (begin > 1 && is_stabilized) compare(begin - kChunk, prepare(begin - kChunk), begin, anchor);
  PreparedFrame before = anchor;
  for (int i = begin + 1; i < end; ++i) {
    PreparedFrame now = prepare(i);
    looks.push_back(look_to_json(frame_look(now)));
    compare(i - 1, before, i, now);
    if (is_stabilized && i > begin + 1) compare(begin, anchor, i, now);
    before = std::move(now);
    control.report(static_cast<double>(i - begin) / (end - begin));
  }
  return {{"pairs", std::move(pairs)}, {"looks", std::move(looks)}};
}

/// For progress: core seconds inside of one process.
double weight_of_pixels(double seconds, double pixel_seconds, double num_pixels) {
  return seconds + pixel_seconds * num_pixels;
}

double num_surveyed(const IngestWork& work, int num_frames) {
  return static_cast<double>(work.project.width()) * work.project.height() * num_frames;
}

/// Weight of so many frames, which are reduced to kPreparedSide; measured on photographs of 128, 512 and 1400 pixels a
/// side.
double chunk_weight(const IngestWork& work, int num_frames) {
  const PixelSize size = reduced_size(work.project, kPreparedSide);
  return num_frames * weight_of_pixels(0.015, 2.9e-7, static_cast<double>(size.width) * size.height);
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
  for (int i = std::max(0, begin - kChunk); i < end; ++i) key.add(work->photo_keys[i]);
  if (work->project.is_handheld()) {
    for (int i = std::max(0, begin - kChunk); i < end; ++i) key.add(place_key(*work, static_cast<std::size_t>(i)));
  }
  for (int i = std::max(0, begin - kChunk); i < end; ++i) {
    if (const std::string gain = gain_key(*work, static_cast<std::size_t>(i)); !gain.empty()) key.add(gain);
  }
  const fs::path file = chunk_file(chunk);
  return {.name = "survey-" + file.stem().string(),
          .outputs = {file},
          .run =
              [work, chunk, file](const fs::path& folder, const RunControl& control) {
                save_json(folder / file, survey_chunk(*work, chunk, folder, control));
                control.report(1.0);
              },
          .key = key.hex(),
          .stage = ingest_stages(*work).survey,
          .weight = chunk_weight(*work, end - begin)};
}

/// Results of the chunks.
struct ComparedFrames {
  std::vector<FramePair> pairs;
  std::vector<FrameLook> looks;  ///< By frame.
};
ComparedFrames read_chunks(const IngestWork& work, const fs::path& folder) {
  ComparedFrames all;
  for (int chunk = 0; chunk * kChunk < num_frames_of(work); ++chunk) {
    const fs::path file = folder / chunk_file(chunk);
    const Json json = load_json(file);
    JsonReader reader(file.string(), json);
    for (const JsonReader& pair : reader.member("pairs").elements()) all.pairs.push_back(pair_from_json(pair));
    for (const JsonReader& look : reader.member("looks").elements()) all.looks.push_back(look_from_json(look));
  }
  return all;
}

/// Pairs across the runs of frames that fit neither neighbor.
std::vector<FramePair> pairs_across(const IngestWork& work, const fs::path& folder, const std::vector<FrameRun>& runs,
                                    const RunControl& control) {
  const RunControl quiet = control.silent();
  std::vector<FramePair> pairs;
  for (const FrameRun& run : runs) {
    control.throw_if_stopped();
    const int from = run.first - 1, to = run.last + 1;
    const PreparedFrame before = prepare_frame(read_frame_roi(work, from, folder), quiet);
    const PreparedFrame after = prepare_frame(read_frame_roi(work, to, folder), quiet);
    pairs.push_back(compare_frames(from, before, to, after, work.options.repair.stabilize));
    control.report(static_cast<double>(pairs.size()) / static_cast<double>(runs.size()));
  }
  return pairs;
}

/// Pairs farther apart where the series falls into groups: a camera that was moved far may have come from where it
/// stood earlier. Stops at the first that fits.
std::vector<FramePair> find_bridges(const IngestWork& work, const fs::path& folder,
                                    const std::vector<FramePair>& neighbors, std::vector<FramePair> pairs,
                                    const LinkTest& is_linked, const RunControl& control) {
  constexpr int kMaxTried = 64;  // Most pairs that are tried: 0.2 s each; a series without any order is not worth more.
  const RunControl quiet = control.silent();
  const int n = num_frames_of(work);
  std::vector<FramePair> bridges;
  std::vector<int> groups = group_frames(n, pairs, is_linked);
  int num_tried = 0;
  const auto ties = [&](int a, int b) {
    if (a < 0 || b >= n || num_tried >= kMaxTried) return false;
    ++num_tried;
    control.throw_if_stopped();
    bridges.push_back(compare_frames(a, prepare_frame(read_frame_roi(work, a, folder), quiet), b,
                                     prepare_frame(read_frame_roi(work, b, folder), quiet),
                                     work.options.repair.stabilize));
    pairs.push_back(bridges.back());
    return is_linked(bridges.back());
  };
  for (const FramePair& cut : neighbors) {
    if (groups[cut.reference] == groups[cut.frame]) continue;
    for (int k = 1; k < kChunk; k *= 2) {
      if (!ties(cut.reference - k, cut.frame) && !ties(cut.reference, cut.frame + k)) continue;
      groups = group_frames(n, pairs, is_linked);
      break;
    }
  }
  return bridges;
}

/// Names a photograph as messages and `exclude` do.
Json photo_json(const CaptureProject& project, const std::vector<std::string>& names, int frame) {
  const CapturePhoto& photo = project.frames[frame];
  return {{"photo", names[frame]}, {"time", photo.time}, {"number", photo.number}};
}

/// Every frame's status under --stabilize. @throws CannotComplete if none can be laid over another one.
Json frame_states(const IngestWork& work, const std::vector<std::string>& names, const StabilizedMotions& motions,
                  double best_similarity_of_all) {
  const int n = num_frames_of(work);
  const PixelRectangle& roi = work.project.roi;
  if (static_cast<int>(motions.unlinked_frames.size()) == n) {
    throw CannotComplete(work.project.file.string() + ": --stabilize: none of the " + std::to_string(n) +
                         " photographs can be aligned with another one (best similarity " +
                         short_number_text(std::max(0.0, std::round(100.0 * best_similarity_of_all) / 100.0)) +
                         " of 1); use photographs of one view, with equal crop and rotation; without --stabilize they "
                         "are used as they are");
  }
  const double least = work.options.repair.survey.shift_threshold_px *
                       std::max(1.0, static_cast<double>(std::max(roi.width, roi.height)) / kPreparedSide);
  Json states = Json::array();
  for (int i = 0; i < n; ++i) {
    const std::size_t k = i;
    Json state = photo_json(work.project, names, i);
    const bool is_unlinked = std::binary_search(motions.unlinked_frames.begin(), motions.unlinked_frames.end(), i);
    const bool is_moved = motion_size(motions.frame_from_first[k], roi.width, roi.height) >= least;
    state["status"] = is_unlinked ? "unlinked" : is_moved ? "registered" : "not moved";
    if (!is_unlinked) state["residual_px"] = motions.frame_residual_px[k];
    states.push_back(std::move(state));
  }
  return states;
}

/// The frames that cannot be laid over most of the others; with how well they fit one of another group, if measured.
Json outside_json(const CaptureProject& project, const std::vector<std::string>& names, const std::vector<int>& groups,
                  const std::vector<FramePair>& pairs) {
  Json list = Json::array();
  for (int frame : frames_outside(groups)) {
    Json entry = photo_json(project, names, frame);
    for (const FramePair& pair : pairs) {
      const bool is_of_frame = pair.frame == frame || pair.reference == frame;
      if (!is_of_frame || groups[pair.frame] == groups[pair.reference]) continue;
      entry["similarity"] = std::max(entry.value("similarity", -1.0), best_similarity(pair));
    }
    list.push_back(std::move(entry));
  }
  return list;
}

Json findings_json(const CaptureProject& project, const std::vector<std::string>& names,
                   const std::vector<FrameFinding>& findings) {
  Json list = Json::array();
  for (const FrameFinding& finding : findings) {
    Json entry = finding_to_json(finding);
    entry.update(photo_json(project, names, finding.odd_frame));
    entry["against"] = names[finding.against];
    entry["is_shifted"] = finding.is_shifted;
    list.push_back(std::move(entry));
  }
  return list;
}

/// The photographs in an order in which they follow one another much better, if there is one; null otherwise.
Json better_order_json(const CaptureProject& project, const std::vector<std::string>& names, const FrameOrder& order) {
  if (!order.is_disordered()) return nullptr;
  Json json{{"detour", rounded(order.detour, 3)},
            {"agreement", rounded(order.agreement, 3)},
            {"best_agreement", rounded(order.best_agreement, 3)},
            {"photos", Json::array()}};
  for (const int frame : order.best) json["photos"].push_back(photo_json(project, names, frame));
  return json;
}

/// Frames that say nothing of the order: those that cannot be laid over most others, and those that are moved where few
/// are.
std::vector<int> without_order(const std::vector<int>& outside, const std::vector<FrameFinding>& findings,
                               int num_frames) {
  std::set<int> moved;
  for (const FrameFinding& finding : findings) {
    if (finding.is_shifted) moved.insert(finding.odd_frame);
  }
  std::set<int> frames(outside.begin(), outside.end());
  if (3 * static_cast<int>(moved.size()) <= num_frames) frames.merge(moved);
  return {frames.begin(), frames.end()};
}

void save_survey(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  const RepairOptions& options = work.options.repair;
  const CaptureProject& project = work.project;
  const PixelRectangle& roi = project.roi;
  const std::vector<std::string> names = photo_names(project.frames);
  ComparedFrames compared = read_chunks(work, folder);
  std::vector<FramePair>& pairs = compared.pairs;
  std::vector<FramePair> neighbors;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(neighbors),
               [](const FramePair& p) { return p.frame == p.reference + 1; });
  const double plain = plain_contrast(neighbors);
  for (FramePair& pair : neighbors) mark_plain(pair, plain);
  std::vector<FrameFinding> findings = judge_frames(neighbors, roi.width, roi.height, options.survey);
  const std::vector<FramePair> across = pairs_across(work, folder, runs_to_skip(neighbors, findings), control);
  pairs.insert(pairs.end(), across.begin(), across.end());
  find_odd_frames(findings, neighbors, across, roi.width, roi.height);
  const LinkTest is_of_one_view = [plain](FramePair pair) {
    mark_plain(pair, plain);
    return !is_unmatched(pair);
  };
  const LinkTest is_linked = options.stabilize ? LinkTest(can_be_laid_over) : is_of_one_view;
  const std::vector<FramePair> bridges = find_bridges(work, folder, neighbors, pairs, is_linked, control);
  pairs.insert(pairs.end(), bridges.begin(), bridges.end());
  Json json{{"format", "patinate.survey"},
            {"version", 2},
            {"stabilized", options.stabilize},
            {"deflickered", options.deflicker}};
  json["excluded"] = project.excluded;
  json["findings"] = findings_json(project, names, findings);
  if (const std::optional<RestlessLight> light = find_restless_light(neighbors, options.survey))
    json["restless_light"] = {{"channel", kChannelNames[light->channel]},
                              {"deviation", rounded(light->deviation, 3)},
                              {"hidden", rounded(light->hidden, 3)}};
  const std::vector<int> groups = group_frames(num_frames_of(work), pairs, is_linked);
  if (options.stabilize) {
    const StabilizedMotions motions = solve_motions(num_frames_of(work), pairs, roi.width, roi.height);
    double best = -1.0;
    for (const FramePair& pair : pairs) best = std::max(best, best_similarity(pair));
    json["frames"] = frame_states(work, names, motions, best);
    json["stabilize_residual_px"] = motions.residual_px;
    json["motions"] = Json::array();
    for (const Eigen::Affine2d& m : motions.frame_from_first) {
      json["motions"].push_back({m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2)});
    }
  }
  const std::vector<int> outside = frames_outside(groups);
  json["unlinked_frames"] = outside;
  const std::vector<int> left_out = without_order(outside, findings, num_frames_of(work));
  if (Json order = better_order_json(project, names, find_order(compared.looks, left_out, control)); !order.is_null())
    json["better_order"] = std::move(order);
  json["unlinked"] = outside_json(project, names, groups, pairs);
  const std::vector<int> apart = frames_outside(group_frames(num_frames_of(work), pairs, is_of_one_view));
  for (std::size_t i = 0; i < outside.size(); ++i)
    json["unlinked"][i]["is_plain"] = !std::binary_search(apart.begin(), apart.end(), outside[i]);
  if (options.deflicker) {
    std::vector<std::array<double, 3>> gains;
    std::vector<bool> is_known;
    for (const FramePair& pair : neighbors) {
      gains.push_back(pair.change.light.log_gain);
      is_known.push_back(pair.change.light.is_sure());
    }
    json["factors"] = named_factors(deflicker_factors(gains, options.deflicker_options, is_known));
  }
  json["pairs"] = Json::array();
  for (const FramePair& pair : neighbors) json["pairs"].push_back(pair_to_json(pair));
  json["pairs_across"] = Json::array();
  for (const auto* list : {&across, &bridges}) {
    for (const FramePair& pair : *list) json["pairs_across"].push_back(pair_to_json(pair));
  }
  save_json(folder / kSurveyFile, json);
}

}  // namespace

IngestStages ingest_stages(const IngestWork& work) {
  const RepairOptions& options = work.options.repair;
  const bool is_repaired = options.stabilize || options.deflicker || !options.flat_field.empty();
  IngestStages stages = is_repaired ? IngestStages{.frames = 2, .survey = 0, .decisions = 1}
                                    : IngestStages{.frames = 0, .survey = 1, .decisions = 2};
  // Photographs are aligned first of all, and patch or chart are measured next.
  const bool is_light_measured = work.project.reference_patch || work.project.chart;
  const int num_before = (needs_alignment(work) ? 1 : 0) + (is_light_measured ? 1 : 0);
  for (int* stage : {&stages.frames, &stages.survey, &stages.decisions}) *stage += num_before;
  return stages;
}

void add_survey_items(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work) {
  if (num_frames_of(*work) > 1) {
    for (int chunk = 0; chunk * kChunk < num_frames_of(*work); ++chunk) items.push_back(chunk_item(work, chunk));
    items.push_back({.name = "survey",
                     .outputs = {kSurveyFile},
                     .run =
                         [work](const fs::path& folder, const RunControl& control) {
                           save_survey(*work, folder, control);
                           control.report(1.0);
                         },
                     .stage = ingest_stages(*work).decisions,
                     .weight = weight_of_pixels(0.02, 2e-8, num_surveyed(*work, num_frames_of(*work)))});
  }
  if (work->options.repair.flat_field.empty()) return;
  items.push_back({.name = "flat-field",
                   .outputs = {kFlatFieldFile},
                   .run =
                       [work](const fs::path& folder, const RunControl& control) {
                         const ImageF gain = make_flat_field(*work, folder, control);
                         ImageF rgb(gain.width(), gain.height(), 3);
                         for (std::int64_t i = 0; i < rgb.num_pixels(); ++i) {
                           for (int c = 0; c < 3; ++c)
                             rgb.data()[3 * i + c] = gain.data()[gain.channels() == 1 ? i : 3 * i + c];
                         }
                         write_exr(folder / kFlatFieldFile, rgb, {"R", "G", "B"}, ExrDepth::Float);
                         control.report(1.0);
                       },
                   .stage = ingest_stages(*work).decisions,
                   .weight = weight_of_pixels(0.03, 3e-7, num_surveyed(*work, num_frames_of(*work)))});
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
