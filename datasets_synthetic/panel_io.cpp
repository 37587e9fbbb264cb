#include "datasets_synthetic/panel_io.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets_synthetic/panel_frame.h"
#include "datasets_synthetic/panel_layout.h"
#include "datasets_synthetic/project_io.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

namespace {

/// Names of the maps that a photograph has.
std::vector<std::string> panel_maps(const PanelOptions& o) {
  std::vector<std::string> maps{"rust"};
  if (o.scribe) maps.emplace_back("scribe");
  if (o.stains > 0.0) maps.emplace_back("stain");
  if (o.crack_density > 0.0) maps.emplace_back("cracks");
  return maps;
}

void write_panel_frame(const PanelLayout& layout, int i, const fs::path& folder, const RunControl& control) {
  const PanelFrame frame = panel_frame(layout, i, control);
  fs::create_directories((folder / photo_file(i)).parent_path());
  write_codes(folder / photo_file(i), frame.photo);
  save_truth_map(folder / truth_file("rust", i), frame.rust);
  if (!frame.scribe.empty()) save_truth_map(folder / truth_file("scribe", i), frame.scribe);
  if (!frame.stain.empty()) save_truth_map(folder / truth_file("stain", i), frame.stain);
  if (!frame.cracks.empty()) save_truth_map(folder / truth_file("cracks", i), frame.cracks);
}

Json panel_capture_json(const PanelOptions& o) {
  Json json = fixed_capture("coated panel", "h");
  json["frames"] = {{"pattern", "frames/*.png"}, {"interval", o.hour(1)}, {"start", 0}};
  json["texel_size_mm"] = o.pixel_mm;
  json["appearance"] = {{"specular", PanelFigures::kF0},
                        {"roughness", Json::array({{0.0, o.roughness}, {o.hours, o.roughness_end}})}};
  return json;
}

Json place_json(const Vec2& place) { return {place.x(), place.y()}; }

Json spots_json(const std::vector<PanelSpot>& spots) {
  Json json = Json::array();
  for (const PanelSpot& spot : spots) {
    json.push_back({{"x_mm", spot.x_mm},
                    {"y_mm", spot.y_mm},
                    {"area_mm2", spot.area_mm2},
                    {"start_h", spot.start_h},
                    {"is_edge", spot.is_edge}});
  }
  return json;
}

Json cracks_json(const std::vector<PanelCrack>& cracks) {
  Json json = Json::array();
  for (const PanelCrack& crack : cracks) {
    Json points = Json::array();
    for (const Vec2& point : crack.points_mm) points.push_back(place_json(point));
    json.push_back({{"points_mm", points},
                    {"length_mm", crack.length_mm},
                    {"width_mm", crack.width_mm},
                    {"start_h", crack.start_h}});
  }
  return json;
}

Json scribe_json(const PanelScribe& scribe) {
  return {{"from_mm", place_json(scribe.from_mm)},
          {"to_mm", place_json(scribe.to_mm)},
          {"width_mm", scribe.width_mm},
          {"step_mm", scribe.step_mm},
          {"left_mm", scribe.left_mm},
          {"right_mm", scribe.right_mm}};
}

Json figures_json(const PanelFigures& f, const PanelOptions& o) {
  Json json{{"time", f.hours},
            {"rust_percent", f.rust_percent},
            {"rust_test_percent", f.rust_test_percent},
            {"paint_lab", f.paint},
            {"roughness", f.roughness}};
  if (o.scribe) {
    json["rusted_percent"] = f.rusted_percent;
    json["rusted_test_percent"] = f.rusted_test_percent;
    json["creep_left_mm"] = f.creep_left_mm;
    json["creep_right_mm"] = f.creep_right_mm;
    json["creep_max_mm"] = f.creep_max_mm;
  }
  if (o.stains > 0.0) json["stain_test_percent"] = f.stain_test_percent;
  if (o.crack_density > 0.0) {
    json["crack_mm_per_mm2"] = f.crack_mm_per_mm2;
    json["crack_area_percent"] = f.crack_area_percent;
  }
  return json;
}

Json panel_truth_json(const PanelLayout& layout, const RunControl& control) {
  const PanelOptions& o = layout.options;
  Json json = truth_header("panel", option_values(o));
  json["test_area"] = {
      {"file", "test_area.exr"}, {"mm2", o.test_area_mm2()}, {"panel_mm2", o.width_mm() * o.height_mm()}};
  json["specular"] = PanelFigures::kF0;
  json["spots"] = spots_json(panel_spots(layout));
  for (const PanelScribe& scribe : layout.scribes)
    json[json.contains("scribe") ? "scribe_across" : "scribe"] = scribe_json(scribe);
  if (!layout.cracks.empty()) json["cracks"] = cracks_json(layout.cracks);
  json["frames"] = Json::array();
  for (int i = 0; i < o.num_frames; ++i) {
    Json frame = figures_json(panel_figures(layout, marks_at(layout, o.hour(i), control.silent()), o.hour(i)), o);
    for (const std::string& map : panel_maps(o))
      frame[map] = truth_file(map, i).lexically_relative("truth").generic_string();
    json["frames"].push_back(std::move(frame));
  }
  return json;
}

}  // namespace

JobPlan plan_panel(const PanelOptions& options, const fs::path& output) {
  check_panel(options);
  JobInputs inputs("synth panel", 1);
  inputs.add_options(option_values(options));
  const auto panel = std::make_shared<MadeOnce<PanelLayout>>(
      [options](const RunControl& control) { return lay_out_panel(options, control); });
  JobPlan plan = plan_capture(
      inputs, output, [options](const RunControl&) { return panel_capture_json(options); },
      [panel](const RunControl& control) { return panel_truth_json(panel->get(control), control); });
  add_frames(plan, options.num_frames, panel_maps(options),
             [panel](int i, const fs::path& folder, const RunControl& control) {
               write_panel_frame(panel->get(control), i, folder, control);
             });
  plan.items.push_back({.name = "truth",
                        .outputs = {"truth/test_area.exr"},
                        .run = [panel](const fs::path& folder, const RunControl& control) {
                          save_truth_map(folder / "truth/test_area.exr", test_area_shares(panel->get(control)));
                        }});
  return plan;
}

}  // namespace patinate::datasets
