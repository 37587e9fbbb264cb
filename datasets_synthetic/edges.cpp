#include "datasets_synthetic/edges.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets_synthetic/project_io.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

namespace {

const Vec3 kGround{0.18, 0.18, 0.18}, kBefore{0.42, 0.20, 0.11}, kAfter{0.12, 0.30, 0.26};

int gap_px(const EdgesOptions& o) { return o.patch_px / 3; }

/// Index of a patch by its name.
constexpr int patch_of(std::string_view name) {
  for (std::size_t i = 0; i < kEdgePatches.size(); ++i) {
    if (kEdgePatches[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

/// Half a code of 8 bits above a linear value.
double half_code_above(double value) {
  const float code = srgb_from_linear(static_cast<float>(value));
  return static_cast<double>(linear_from_srgb(code + 0.5f / 255.0f));
}

/// Colors that a patch goes from, and to.
std::array<Vec3, 2> ends_of(int patch) {
  switch (patch) {
    case patch_of("constant"):
      return {kGround * 2.0, kGround * 2.0};
    case patch_of("black"):
      return {Vec3::Zero(), Vec3::Zero()};
    case patch_of("white"):
      return {Vec3::Ones(), Vec3::Ones()};
    case patch_of("red_saturated"):
      return {Vec3(1.0, 0.6, 0.3), Vec3(1.0, 0.2, 0.3)};
    case patch_of("faint"):
      return {kBefore, Vec3(half_code_above(kBefore[0]), half_code_above(kBefore[1]), half_code_above(kBefore[2]))};
    case patch_of("spoilt_once"):
      return {kGround, Vec3::Ones()};
    default:
      return {kBefore, kAfter};
  }
}

Json edges_capture_json() {
  Json json = fixed_capture("edge cases", "h");
  json["frames"] = Json::array();
  for (std::size_t i = 0; i < kEdgeTimes.size(); ++i)
    json["frames"].push_back({{"time", kEdgeTimes[i]}, {"photo", photo_file(static_cast<int>(i)).generic_string()}});
  json["mask"] = "mask.png";
  return json;
}

Json edges_truth_json(const EdgesOptions& o) {
  Json json = truth_header("edges", option_values(o));
  json["patches"] = Json::array();
  for (std::size_t k = 0; k < kEdgePatches.size(); ++k) {
    Json course = Json::array();
    for (std::size_t i = 0; i < kEdgeTimes.size(); ++i)
      course.push_back(edge_course(static_cast<int>(k), static_cast<int>(i)));
    json["patches"].push_back({{"number", k},
                               {"name", std::string(kEdgePatches[k].name)},
                               {"what", std::string(kEdgePatches[k].what)},
                               {"course", std::move(course)}});
  }
  json["times"] = kEdgeTimes;
  return json;
}

void write_edges_frame(const EdgesOptions& o, int frame, const fs::path& folder) {
  const int side = edges_side(o);
  ImageF card(side, side, 3);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const Vec3 color = edge_color(o, x, y, frame);
      for (int c = 0; c < 3; ++c) card.at(x, y, c) = static_cast<float>(color[c]);
    }
  }
  save_photograph(folder / photo_file(frame), card, o.noise, o.seed, frame);
  save_truth_map(folder / truth_file("albedo", frame), card);
}

void write_edges_maps(const EdgesOptions& o, const fs::path& folder) {
  const int side = edges_side(o);
  ImageF patches(side, side);
  ImageU8 mask(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      patches.at(x, y) = static_cast<float>(edge_patch_at(o, x, y));
      mask.at(x, y) = x + y < gap_px(o) ? 0 : 255;
    }
  }
  write_codes(folder / "mask.png", mask);
  save_truth_map(folder / "truth/patches.exr", patches);
}

}  // namespace

void describe(OptionVisitor& v, EdgesOptions& o) {
  v.visit({"patch", "Side of a patch", "px", between(16, 512)}, o.patch_px);
  v.visit({"noise", "Standard deviation of the noise that is added to the photographs; 1 = full scale", "",
           between(0, 0.5)},
          o.noise);
  v.visit({"seed", "Every random choice derives from it", "", at_least(0)}, o.seed);
}

int edges_side(const EdgesOptions& o) { return gap_px(o) + kEdgeColumns * (o.patch_px + gap_px(o)); }

int edge_patch_at(const EdgesOptions& o, int x, int y) {
  const int step = o.patch_px + gap_px(o);
  const int u = x - gap_px(o), v = y - gap_px(o);
  if (u < 0 || v < 0 || u % step >= o.patch_px || v % step >= o.patch_px) return -1;
  return v / step * kEdgeColumns + u / step;
}

double edge_course(int patch, int frame) {
  const double time = kEdgeTimes.at(static_cast<std::size_t>(frame)), share = time / kEdgeTimes.back();
  const int last = static_cast<int>(kEdgeTimes.size()) - 1;
  switch (patch) {
    case patch_of("step"):
      return time > 5.0 ? 1.0 : 0.0;
    case patch_of("step_first"):
      return frame > 0 ? 1.0 : 0.0;
    case patch_of("step_last"):
      return frame == last ? 1.0 : 0.0;
    case patch_of("soon"):
      return -std::expm1(-time / 0.3);
    case patch_of("late"):
      return std::max(0.0, 2.0 * share - 1.0);
    case patch_of("wiped"):
      return 1.0 - std::abs(2.0 * share - 1.0);
    case patch_of("to_and_fro"):
      return frame % 2;
    case patch_of("spoilt_once"):
      return time == 11.0 ? 1.0 : 0.0;
    case patch_of("constant"):
    case patch_of("black"):
    case patch_of("white"):
      return 0.0;
    default:
      return share;
  }
}

Vec3 edge_color(const EdgesOptions& o, int x, int y, int frame) {
  const int patch = edge_patch_at(o, x, y);
  if (patch < 0) return kGround;
  const std::array<Vec3, 2> ends = ends_of(patch);
  double share = edge_course(patch, frame);
  if (patch == patch_of("chessboard") && (x + y) % 2 == 1) share = 1.0 - share;
  if (patch == patch_of("line") && (x - gap_px(o)) % (o.patch_px + gap_px(o)) != o.patch_px / 2) share = 0.0;
  return (1.0 - share) * ends[0] + share * ends[1];
}

JobPlan plan_edges(const EdgesOptions& options, const fs::path& output) {
  check_ranges(options);
  JobInputs inputs("synth edges", 1);
  inputs.add_options(option_values(options));
  JobPlan plan = plan_capture(
      inputs, output, [](const RunControl&) { return edges_capture_json(); },
      [options](const RunControl&) { return edges_truth_json(options); });
  add_frames(plan, static_cast<int>(kEdgeTimes.size()), {"albedo"},
             [options](int i, const fs::path& folder, const RunControl&) { write_edges_frame(options, i, folder); });
  plan.items.push_back(
      {.name = "truth",
       .outputs = {"mask.png", "truth/patches.exr"},
       .run = [options](const fs::path& folder, const RunControl&) { write_edges_maps(options, folder); }});
  return plan;
}

}  // namespace patinate::datasets
