#include <nlohmann/json.hpp>

#include "datasets_synthetic/bars.h"
#include "patinate/core/error.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {

namespace {

constexpr double kInside = 0.04;    // of the wall's width: how far a sill enters the wall
constexpr double kFall = 0.08;      // slope of a sill's top
constexpr double kUnderside = 0.8;  // slope of its underside, back to the wall

}  // namespace

void describe(OptionVisitor& v, LedgeOptions& o) {
  v.visit({"width", "Width and height of the wall", "mm", above(0)}, o.width_mm);
  v.visit({"depth", "By how much the sills stand out; at most a fifth of the width", "mm", above(0)}, o.depth_mm);
  v.visit({"thickness", "Of a sill's front; at most a tenth of the width", "mm", above(0)}, o.thickness_mm);
  v.visit({"sills", "Sills, one above the other and beside each other in turn", "", between(1, 6)}, o.num_sills);
  v.visit({"cells", "Squares along the wall", "", between(1, 400)}, o.cells);
  v.visit({"charts",
           "Charts that a face is cut into along its longer side, each turned by an angle of its own: to see how "
           "little seams show",
           "", between(1, 24)},
          o.num_charts);
  v.visit_choice(
      {"weather", "The scene's: dust that rain carries off the sills, or soot that rain washes off the wall"},
      o.weather, kWeatherNames);
}

Mesh ledge(const LedgeOptions& options) {
  check_ranges(options);
  const double w = options.width_mm;
  if (options.thickness_mm > 0.1 * w) throw InvalidInput("a sill is thicker than a tenth of the wall's width");
  if (options.depth_mm > 0.2 * w) throw InvalidInput("a sill stands out by more than a fifth of the wall's width");
  std::vector<Face> faces;
  add_bar(faces, -0.5 * w, 0.5 * w, {Vec2(0, 0), Vec2(0, -0.1 * w), Vec2(w, -0.1 * w), Vec2(w, 0)}, w / options.cells);
  for (int i = 0; i < options.num_sills; ++i) {
    const double y = w * (0.84 - 0.6 * i / options.num_sills);
    const double middle = options.num_sills == 1 ? 0.0 : (i % 2 == 0 ? -0.2 : 0.22) * w;
    const double half = (0.24 - 0.02 * i) * w;
    const double d = options.depth_mm, back = -kInside * w, t = options.thickness_mm;
    // The underside falls back toward the wall, so that water creeps along it and down.
    add_bar(faces, middle - half, middle + half,
            {Vec2(y - kFall * d - t, d), Vec2(y - kFall * d - t - kUnderside * (d - back), back),
             Vec2(y - kFall * back, back), Vec2(y - kFall * d, d)},
            w / options.cells);
  }
  return mesh_of_faces(in_patches(faces, options.num_charts), w, "wall", "plaster");
}

std::string ledge_scene(const LedgeOptions& options, const std::string& mesh_file) {
  using Json = nlohmann::ordered_json;
  const double w = options.width_mm;
  Json json{{"format", "patinate.scene"}, {"version", 2}, {"unit", "mm"}, {"gravity", {0, -9810, 0}}, {"seed", 1}};
  json["atlas"] = {{"resolution", 1024}};
  json["objects"] = Json::array({{{"name", "wall"}, {"mesh", mesh_file}, {"preset", "plaster"}}});
  json["behavior"] = {
      {"bounce", 0.02}, {"float", 0.97}, {"absorb", 0.01}, {"deceleration_bounce", 0.6}, {"deceleration_float", 0.2}};
  json["tracing"] = {{"epsilon", 0.002 * w},       {"pull", 0.003 * w},       {"reach", 0.005 * w},
                     {"lobe_exponent_float", 800}, {"rest_speed", 0.002 * w}, {"wet_attraction", 0.5}};
  // No plaster dries evenly. Drops join where it stays wet, so that runs come as they like and not as a comb.
  json["maps"] = {{"damp", {{"kind", "noise"}, {"wavelength_mm", 0.16 * w}, {"octaves", 5}, {"seed", 3}}}};
  const Json drying{{"name", "evaporation"}, {"driver", "water * (0.2 + 4*damp*damp)"}, {"rate", 0.5}};
  json["time"] = {{"unit", "d"}, {"per_iteration", 0.05}, {"contact", 1.0}};
  if (options.weather == LedgeWeather::Dust) {
    json["materials"] = {"water", "dirt", "organic", "moss"};
    json["appearance"] = {{"dirt", {{"color", {0.05, 0.04, 0.03}}, {"strength", 2.3}}}};
    // Dust settles on what looks up; slanting rain takes it over the edge, along the underside and down the wall.
    json["emitters"] = Json::array({{{"name", "rain"},
                                     {"shape", "sky"},
                                     {"direction", {0, -1, -0.12}},
                                     {"spread_deg", 4},
                                     {"speed", 3 * w},
                                     {"gammatons", 2500},
                                     {"carries", {{"water", 0.8}}}},
                                    {{"name", "dust"},
                                     {"shape", "sky"},
                                     {"direction", {0, -1, -0.02}},
                                     {"spread_deg", 3},
                                     {"speed", w},
                                     {"gammatons", 2000},
                                     {"carries", {{"dirt", 1.0}}}}});
    json["exchange"] = {{"ratio", 0.4}, {"rates", {{"water", 0.3}, {"dirt", 0.06}}}};
    json["rules"] = Json::array({drying, {{"name", "moss"}, {"rate", 0.02}}});
    json["run"] = {
        {"iterations", 1000}, {"history_every", 100}, {"controls", {"hits", "water.deposited", "dirt.final"}}};
  } else {
    json["materials"] = {"water", "dirt"};
    json["appearance"] = {{"water", {{"strength", 0.12}}},
                          {"dirt", {{"color", {0.03, 0.027, 0.024}}, {"strength", 0.85}, {"variation", 0.12}}}};
    // Rain that hardly soaks in runs down to the ground, and gathers to runs of many widths: where it dries differs
    // much. It takes nearly all soot in the open. No two drops come from one direction, or the edge of a sheltered
    // place would be as straight as its sill.
    json["behavior"].update({{"float", 0.9795}, {"absorb", 0.0005}});
    json["tracing"].update({{"lobe_exponent_float", 500}, {"wet_attraction", 0.6}, {"rivulet_mm", 0.016 * w}});
    json["maps"]["damp"]["wavelength_mm"] = 0.26 * w;
    json["maps"]["even"] = {{"kind", "noise"}, {"wavelength_mm", 0.3 * w}, {"octaves", 4}, {"seed", 8}};
    // Soot comes from the air, everywhere, until it rains; a low ratio makes drops take it away. Where sills keep the
    // rain off, it stays.
    json["emitters"] = Json::array({{{"name", "rain"},
                                     {"shape", "sky"},
                                     {"direction", {0.2, -1, -0.4}},
                                     {"spread_deg", 12},
                                     {"speed", 3 * w},
                                     {"gammatons", 16000},
                                     {"carries", {{"water", 0.8}}},
                                     {"on", false}}});
    json["exchange"] = {{"ratio", 0.02}, {"rates", {{"water", 0.3}, {"dirt", 0.35}}}};
    json["rules"] = Json::array(
        {{{"name", "evaporation"}, {"driver", "water * (0.05 + 8*damp*damp*damp)"}, {"rate", 0.8}},
         {{"name", "soot"}, {"driver", "max(0, 0.55 + 0.9*even - dirt)"}, {"rate", 0.1}, {"products", {{"dirt", 1}}}}});
    json["events"] = Json::array({{{"iteration", 400}, {"op", "switch"}, {"target", "rain"}, {"on", true}},
                                  {{"iteration", 400}, {"op", "rule"}, {"target", "soot"}, {"rate", 0}}});
    json["run"] = {{"iterations", 800}, {"history_every", 100}, {"controls", {"hits", "dirt.final"}}};
  }
  return json.dump(2) + "\n";
}

}  // namespace patinate::datasets
