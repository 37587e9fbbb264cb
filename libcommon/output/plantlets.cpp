#include "libcommon/output/plantlets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/random.h"
#include "libcommon/output/cushions.h"
#include "libcommon/output/orbit_camera.h"
#include "libcommon/output/render_light.h"
#include "libcommon/output/sampling.h"

namespace patinate {

namespace {

constexpr double kMinAmount = 0.18, kMostAmount = 0.75;  // The first grows here, the last there.
constexpr double kPlantsPerSquare = 1.5;                 // Plants per square of a plant's size: leaves touch.
constexpr double kSize = 1.0 / 220;                      // Share of the diagonal.
constexpr double kMaxPlaces = 100000;
constexpr double kInCushion = 0.7;  // Share of what decides from which amount on a plant shows; the rest is chance.
constexpr double kDome = 1.4;       // By which a plant in the middle of the largest cushion is taller.
constexpr double kSpread = 0.7;     // Tangent by which those at its rim lean outward.
constexpr double kOwnColor = 0.5;   // Share of a leaf's color that is not that of what it grows on.
constexpr double kBelowLight =
    1.3;                            // Factor of the color of what it grows on: leaves are lighter than the stems' dark.
constexpr double kUpright = 0.35;   // Share by which plants turn from the surface's normal upward.
constexpr double kSeedling = 0.35;  // Height of a plant that has just come, of what it grows to ...
constexpr double kGrowth = 0.25;    // ... while the amount rises by this.
constexpr int kLeaves = 6;
constexpr int kTrianglesPerPlant = 2 * kLeaves;
constexpr std::uint32_t kPlace = 34;  // Purpose of random streams.

// Corners of a leaf's two triangles, by index into root, left, right, tip, and how light they are.
constexpr std::array<std::array<int, 3>, 2> kLeafTriangles{{{0, 1, 2}, {1, 3, 2}}};
constexpr std::array<double, 4> kLeafShades{0.45, 0.85, 0.85, 1.15};

/// How leaves stand around a stem, in heights of the plant.
struct LeafForm {
  double lean, more_lean;  ///< Distance of a tip from the stem; by up to `more_lean` farther from leaf to leaf.
  double half_width, tip;  ///< Half width and tip of a leaf, in its middle; height of its tip.
};
// Shoots with narrow leaves, tufts and flat rosettes.
constexpr std::array<LeafForm, kNumPlantKinds> kForms{
    {{0.16, 0.3, 0.06, 1.0}, {0.35, 0.25, 0.14, 0.9}, {0.7, 0.3, 0.17, 0.5}}};

// The leaf's points around an upright stem along z.
std::array<Vec3, 4> leaf_points(const LeafForm& form, int leaf) {
  const double angle = 2.0 * std::numbers::pi * leaf / kLeaves,
               lean = form.lean + form.more_lean * ((leaf * 7) % 3) / 2.0;
  const double c = std::cos(angle), s = std::sin(angle);
  const auto at = [&](double out, double side, double z) { return Vec3(out * c - side * s, out * s + side * c, z); };
  return {at(0, 0, 0), at(lean * 0.5, -form.half_width, 0.55 * form.tip),
          at(lean * 0.5, form.half_width, 0.55 * form.tip), at(lean, 0, form.tip)};
}

/// A cushion is mostly of one kind: the tone that it has, and chance.
int plant_kind(double tone, double chance) {
  return std::min(static_cast<int>(kNumPlantKinds * (0.75 * tone + 0.25 * chance)), kNumPlantKinds - 1);
}

/// Color of leaves, linear: from olive through green to yellow.
Vec3 tone_color(double tone) {
  const Vec3 olive(0.085, 0.085, 0.022), green(0.085, 0.165, 0.026), yellow(0.210, 0.260, 0.045);
  return tone < 0.5 ? Vec3(olive + 2.0 * tone * (green - olive)) : Vec3(green + (2.0 * tone - 1.0) * (yellow - green));
}

double total_area(const Mesh& mesh) {
  double area = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) area += 0.5 * area_vector(mesh, t).norm();
  return area;
}

}  // namespace

double PlantPlace::height_at(double amount) const {
  return amount < threshold ? 0.0 : kSeedling + (1.0 - kSeedling) * std::min(1.0, (amount - threshold) / kGrowth);
}

std::vector<PlantPlace> plant_places(const Mesh& given, const RenderOptions& options, const SurfaceOptions& surface) {
  std::vector<PlantPlace> places;
  if (!(surface.plants > 0.0)) return places;
  const Mesh mesh = with_normals(given);
  const Vec3 up = world_from_y_up(Vec3::UnitY(), options.up);
  const double size = surface.plant_size > 0.0 ? surface.plant_size : kSize * bounding_box(mesh).diagonal();
  const double area = total_area(mesh), cushion_size = surface.plant_cushion * size;
  const double density = std::min(surface.plants * kPlantsPerSquare / (size * size), kMaxPlaces / area);
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const std::size_t k = t;
    std::array<Vec3, 3> p, n;
    std::array<Vec2, 3> uv;
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = mesh.positions[mesh.triangles[k][c]];
      n[c] = mesh.normals[mesh.normal_triangles[k][c]];
      uv[c] = mesh.uvs[mesh.uv_triangles[k][c]];
    }
    RandomStream random(kRenderSeed, k, kPlace);
    const double expected = density * 0.5 * area_vector(mesh, t).norm();
    const int count = static_cast<int>(expected + random.uniform());
    for (int i = 0; i < count; ++i) {
      const double root = std::sqrt(random.uniform()), along = random.uniform();
      const double b1 = root * (1.0 - along), b2 = root * along;
      PlantPlace place{.plant = {.root = blend(p, b1, b2), .uv = blend(uv, b1, b2)}, .triangle = t};
      Plant& plant = place.plant;
      const CushionPlace cushion = cushion_size > 0.0 ? cushion_at(plant.root, cushion_size) : CushionPlace{};
      const double chance = random.uniform();
      const double late =
          cushion_size > 0.0 ? kInCushion * (1.0 - cushion.depth) + (1.0 - kInCushion) * chance : chance;
      place.threshold = kMinAmount + (kMostAmount - kMinAmount) * late;
      plant.turn = 2.0 * std::numbers::pi * random.uniform();
      plant.size = size * (0.5 + random.uniform()) * (1.0 + kDome * cushion.height);
      const double shade = 0.75 + 0.5 * random.uniform();
      plant.kind = plant_kind(cushion.tone, random.uniform());
      plant.place = static_cast<std::uint64_t>(t) << 32 | static_cast<std::uint32_t>(i);
      place.own_color = shade * kOwnColor * tone_color(cushion.tone);
      place.share_below = shade * (1.0 - kOwnColor) * kBelowLight;
      place.normal = blend(n, b1, b2).normalized();
      const Vec3 grows = (1.0 - kUpright) * place.normal + kUpright * up + kSpread * cushion.outward;
      plant.up = grows.norm() > 1e-6 ? Vec3(grows.normalized()) : place.normal;
      places.push_back(place);
    }
  }
  return places;
}

std::vector<Plant> find_plants(const Mesh& mesh, const SurfaceMaps& maps, const RenderOptions& options,
                               const SurfaceOptions& surface) {
  std::vector<Plant> plants;
  if (maps.plants.empty()) return plants;
  for (const PlantPlace& place : plant_places(mesh, options, surface)) {
    Plant plant = place.plant;
    const double height = place.height_at(texture_at(maps.plants, plant.uv.x(), plant.uv.y())[0]);
    if (!(height > 0.0)) continue;
    plant.size *= height;
    const std::array<double, 3> below = texture_at(maps.color, plant.uv.x(), plant.uv.y());
    plant.color = place.own_color + place.share_below * Vec3(below.data());
    if (!maps.height.empty())
      plant.root += surface.relief * texture_at(maps.height, plant.uv.x(), plant.uv.y())[0] * place.normal;
    plants.push_back(plant);
  }
  return plants;
}

Vec3 PlantField::color(std::size_t triangle, double b1, double b2) const {
  const std::size_t within = triangle - first_;
  const std::array<int, 3>& corners = kLeafTriangles[within % 2];
  std::array<double, 3> shade;
  for (std::size_t c = 0; c < 3; ++c) shade[c] = kLeafShades[corners[c]];
  return blend(shade, b1, b2) * colors_[within / kTrianglesPerPlant];
}

PlantShape plant_shape(int kind) {
  PlantShape shape;
  for (int leaf = 0; leaf < kLeaves; ++leaf) {
    const int first = static_cast<int>(shape.positions.size());
    for (const Vec3& point : leaf_points(kForms[static_cast<std::size_t>(kind)], leaf))
      shape.positions.push_back(point);
    shape.shades.insert(shape.shades.end(), kLeafShades.begin(), kLeafShades.end());
    for (const std::array<int, 3>& corners : kLeafTriangles)
      shape.triangles.push_back({first + corners[0], first + corners[1], first + corners[2]});
  }
  return shape;
}

Eigen::Matrix3d plant_frame(const Vec3& up, double turn) {
  Vec3 a, b;
  tangents(up, a, b);
  const double c = std::cos(turn), s = std::sin(turn);
  Eigen::Matrix3d frame;
  frame.col(0) = c * a + s * b;
  frame.col(1) = c * b - s * a;
  frame.col(2) = up;
  return frame;
}

PlantField add_plants(Mesh& mesh, const std::vector<Plant>& plants, std::vector<float>& open) {
  std::array<PlantShape, kNumPlantKinds> shapes;
  for (int kind = 0; kind < kNumPlantKinds; ++kind) shapes[static_cast<std::size_t>(kind)] = plant_shape(kind);
  std::vector<Vec3> colors;
  const std::size_t first = mesh.triangles.size();
  for (const Plant& plant : plants) {
    const PlantShape& shape = shapes[static_cast<std::size_t>(plant.kind)];
    const Eigen::Matrix3d frame = plant_frame(plant.up, plant.turn);
    const int position = static_cast<int>(mesh.positions.size());
    const int uv = static_cast<int>(mesh.uvs.size());
    mesh.uvs.push_back(plant.uv);
    for (const Vec3& local : shape.positions) {
      mesh.positions.push_back(plant.root + plant.size * (frame * local));
      open.push_back(1.0f);
    }
    for (const Triangle& corners : shape.triangles) {
      mesh.triangles.push_back({position + corners[0], position + corners[1], position + corners[2]});
      mesh.triangle_surface.push_back(0);
      mesh.uv_triangles.push_back({uv, uv, uv});
      const int normal = static_cast<int>(mesh.normals.size());
      mesh.normals.push_back(area_vector(mesh, mesh.num_triangles() - 1).normalized());
      mesh.normal_triangles.push_back({normal, normal, normal});
    }
    colors.push_back(plant.color);
  }
  return {first, std::move(colors)};
}

}  // namespace patinate
