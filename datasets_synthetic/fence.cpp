#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "datasets_synthetic/bars.h"
#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {

namespace {

const Vec3 kWood{0.355, 0.195, 0.092};  // linear RGB

struct Parts {
  std::vector<Face> faces;
  std::vector<int> body;         ///< Body of each face.
  std::vector<bool> is_upright;  ///< For each body: how its grain runs.
  void add(double x0, double x1, const std::array<Vec2, 4>& section_yz, double cell_mm, bool upright) {
    add_bar(faces, x0, x1, section_yz, cell_mm);
    body.resize(faces.size(), static_cast<int>(is_upright.size()));
    is_upright.push_back(upright);
  }
};

Parts parts_of(const FenceOptions& options) {
  check_ranges(options);
  const double h = options.height_mm, cell = h / options.cells, plank = h / 9.0;
  RandomStream random(static_cast<std::uint64_t>(options.seed), 0);
  Parts parts;
  double x = 0.0;
  std::vector<std::array<double, 4>> planks;  // left, right, foot, top
  for (int i = 0; i < options.num_planks; ++i) {
    const double width = plank * (0.92 + 0.16 * random.uniform());
    planks.push_back({x, x + width, h * (0.03 + 0.025 * random.uniform()), h * (0.955 + 0.03 * random.uniform())});
    x += width + 0.1 * plank * (0.7 + 0.6 * random.uniform());
  }
  const double half = 0.5 * x, thick = 0.024 * h, post = 0.1 * h;
  // Tops fall to the front, so that they shed water.
  const auto slab = [&](double foot, double top, double back, double front, double fall) {
    return std::array<Vec2, 4>{Vec2(foot, front), Vec2(foot, back), Vec2(top, back), Vec2(top - fall, front)};
  };
  for (const auto& p : planks)
    parts.add(p[0] - half, p[1] - half, slab(p[2], p[3], -thick, 0.0, 0.5 * thick), cell, true);
  for (const double foot : {0.2, 0.72}) {
    parts.add(-half - 0.5 * post, half + 0.5 * post,
              slab(foot * h, (foot + 0.075) * h, -0.4 * thick, 0.045 * h, 0.002 * h), cell, false);
  }
  for (const double side : {-1.0, 1.0}) {
    const double middle = side * (half + 0.75 * post);
    parts.add(middle - 0.5 * post, middle + 0.5 * post, slab(0.0, 1.04 * h, -0.6 * post, 0.4 * post, 0.15 * post), cell,
              true);
  }
  return parts;
}

Mesh mesh_of(const FenceOptions& options, const Parts& parts) {
  return mesh_of_faces(parts.faces, options.height_mm, "fence", "wood");
}

}  // namespace

void describe(OptionVisitor& v, FenceOptions& o) {
  v.visit({"height", "Of the fence", "mm", above(0)}, o.height_mm);
  v.visit({"planks", "Planks beside each other", "", between(1, 40)}, o.num_planks);
  v.visit({"cells", "Squares along the height", "", between(1, 200)}, o.cells);
  v.visit({"texture", "Side of the picture of the wood's grain", "px", between(16, 4096)}, o.texture_px);
  v.visit({"seed", "Other planks, other grain", "", at_least(0)}, o.seed);
}

Mesh fence(const FenceOptions& options) { return mesh_of(options, parts_of(options)); }

ImageF fence_grain(const FenceOptions& options, const RunControl& control) {
  const Parts parts = parts_of(options);
  const TexelMap map(mesh_of(options, parts), options.texture_px, options.texture_px, control.part(0.0, 0.3));
  std::vector<int> body_of_triangle;
  for (std::size_t f = 0; f < parts.faces.size(); ++f) {
    const std::size_t count =
        2 * static_cast<std::size_t>(parts.faces[f].cells_x) * static_cast<std::size_t>(parts.faces[f].cells_y);
    body_of_triangle.insert(body_of_triangle.end(), count, parts.body[f]);
  }
  // Rings are long in one direction. Each body has a strip of the noise of its own.
  const double h = options.height_mm, wide = 0.4 * h, length = 3.0 * h + 0.2 * h * options.num_planks;
  const double all = wide * static_cast<double>(parts.is_upright.size());
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const SmoothNoise bend(seed, 1, all, length, 0.05 * h, 0.6 * h), fibre(seed, 2, all, length, 0.0022 * h, 0.12 * h),
      fine(seed, 3, all, length, 0.0011 * h, 0.02 * h);
  std::vector<double> tint;
  for (std::size_t b = 0; b < parts.is_upright.size(); ++b)
    tint.push_back(0.85 + 0.3 * RandomStream(seed, 4 + b).uniform());
  ImageF image(options.texture_px, options.texture_px, 3);
  parallel_for(options.texture_px, 16, control.part(0.3, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < options.texture_px; ++x) {
        const TexelId texel = std::int64_t{y} * options.texture_px + x;
        Vec3 color = kWood;
        if (map.is_covered(texel)) {
          const auto body = static_cast<std::size_t>(body_of_triangle[map.point(texel).triangle]);
          const Vec3 p = map.position_mm(texel);
          const double along = (parts.is_upright[body] ? p.y() : p.x()) + 0.5 * length;
          const double across = std::fmod((parts.is_upright[body] ? p.x() : p.y()) + 0.6 * p.z() + 10.0 * wide, wide) +
                                wide * static_cast<double>(body);
          const double ring =
              0.5 + 0.5 * std::sin(2.0 * 3.14159265358979 * (across / (0.016 * h) + 2.2 * bend(across, along)));
          const double tone =
              tint[body] * (1.0 - 0.30 * ring * ring + 0.16 * fibre(across, along) + 0.12 * fine(across, along));
          color = (kWood * tone).cwiseMin(1.0).cwiseMax(0.0);
        }
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(color[c]);
      }
    }
  });
  return image;
}

std::string fence_scene(const FenceOptions& options, const std::string& mesh_file, const std::string& grain_file) {
  using Json = nlohmann::ordered_json;
  const double h = options.height_mm;
  Json json{{"format", "patinate.scene"}, {"version", 2}, {"unit", "mm"}, {"gravity", {0, -9810, 0}}, {"seed", 1}};
  json["atlas"] = {{"resolution", 1024}};
  json["materials"] = {"water", "wood", "gray", "organic", "moss", "dirt"};
  json["appearance"] = {{"gray",
                         {{"color", {0.33, 0.315, 0.29}},
                          {"second_color", {0.21, 0.2, 0.185}},
                          {"grain", 0.06 * h},
                          {"strength", 0.75},
                          {"variation", 0.3},
                          {"specular", -0.15}}},
                        {"water", {{"strength", 0.25}}},
                        {"organic", {{"color", {0.026, 0.023, 0.016}}, {"strength", 0.8}, {"variation", 0.3}}},
                        {"moss",
                         {{"color", {0.055, 0.085, 0.018}},
                          {"strength", 1.0},
                          {"variation", 0.4},
                          {"height", 0.6},
                          {"height_variation", 0.4}}}};
  json["objects"] =
      Json::array({{{"name", "fence"}, {"mesh", mesh_file}, {"preset", "wood"}, {"maps", {{"color", grain_file}}}}});
  json["maps"] = {{"damp", {{"kind", "noise"}, {"wavelength_mm", 0.12 * h}, {"octaves", 4}, {"seed", 3}}},
                  {"patches", {{"kind", "noise"}, {"wavelength_mm", 0.25 * h}, {"octaves", 5}, {"seed", 4}}}};
  // Rain from the front, and what it splashes up from the ground.
  json["emitters"] = Json::array({{{"name", "rain"},
                                   {"shape", "sky"},
                                   {"direction", {0.05, -1, -0.2}},
                                   {"spread_deg", 12},
                                   {"speed", 3 * h},
                                   {"gammatons", 5000},
                                   {"carries", {{"water", 0.8}}}},
                                  {{"name", "splash"},
                                   {"shape", "rectangle"},
                                   {"position", {0, 0.002 * h, 0.18 * h}},
                                   {"direction", {0, 1, -0.25}},
                                   {"size", {1.25 * h, 0.4 * h}},
                                   {"spread_deg", 58},
                                   {"speed", 2.9 * h},
                                   {"gammatons", 2500},
                                   {"carries", {{"water", 0.9}, {"dirt", 0.25}}}}});
  json["behavior"] = {
      {"bounce", 0.05}, {"float", 0.92}, {"absorb", 0.03}, {"deceleration_bounce", 0.6}, {"deceleration_float", 0.25}};
  json["tracing"] = {{"lobe_exponent_float", 600}, {"rest_speed", 0.01 * h}};
  json["time"] = {{"unit", "d"}, {"per_iteration", 1.0}};
  json["exchange"] = {{"ratio", 0.45}, {"rates", {{"water", 0.35}, {"dirt", 0.12}, {"organic", 0.02}}}};
  json["rules"] = Json::array(
      {{{"name", "graying"},
        {"driver", "max(0, 1 - gray) * (0.1 + exposure)"},
        {"rate", 0.004},
        {"products", {{"gray", 1}}}},
       {{"name", "decay"}, {"driver", "min(water, wood) * (0.2 + 2*accessibility) * 2*patches"}, {"rate", 0.007}},
       {{"name", "moss"},
        {"driver", "min(water, 0.3*organic + 0.3*dirt) * max(0, 1.5 - moss) * (0.06 + moss)"},
        {"where", "smoothstep(0.45, 0.65, patches)"},
        {"rate", 0.12}},
       {{"name", "evaporation"},
        {"driver", "water * (0.05 + exposure*exposure) * (0.3 + 3*damp*damp)"},
        {"rate", 0.15}}});
  json["run"] = {{"iterations", 1000}, {"history_every", 250}, {"controls", {"hits", "organic.final"}}};
  return json.dump(2) + "\n";
}

}  // namespace patinate::datasets
