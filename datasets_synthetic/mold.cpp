#include "datasets_synthetic/mold.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "libcommon/core/random.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/height_field.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kDents = 200;  // Purposes of random streams.
constexpr std::uint32_t kMottle = 210;
constexpr double kCurvatureGrid = 1.0 / 150.0;  ///< Spacing of the curvature's grid, in radii.
constexpr double kNormalStep = 1e-4;

// All in radii of the mold.
constexpr double kHeight = 0.24;
constexpr double kFootOfWall = 0.83, kTopOfWall = 0.44;

double bump(double x) { return std::exp(-x * x); }

}  // namespace

void describe(OptionVisitor& v, MoldOptions& o) {
  v.visit({"width", "Width of the photographs", "px", between(32, 4096)}, o.width);
  v.visit({"height", "Height of the photographs", "px", between(32, 4096)}, o.height);
  v.visit({"steps", "How often it is scanned and photographed", "", between(1, 1000)}, o.num_steps);
  v.visit({"lights", "Photographs per step, one under each light", "", between(1, 64)}, o.num_lights);
  v.visit({"interval", "Time between steps", "d", above(0)}, o.interval_d);
  v.visit({"radius", "Radius of the mold", "mm", above(0)}, o.radius_mm);
  v.visit({"spokes", "Spokes of the mold", "", between(0, 40)}, o.num_spokes);
  v.visit({"dents", "Dents in the mold", "", between(0, 100)}, o.num_dents);
  v.visit({"scan_spacing", "Distance between the scanner's points", "mm", above(0)}, o.scan_spacing_mm);
  v.visit({"scan_noise", "Standard deviation of the scanner's points", "mm", at_least(0)}, o.scan_noise_mm);
  v.visit({"noise",
           "Standard deviation of photographs, in sRGB codes / 255; with this and `scan_noise` 0 they are float images "
           "of the scan's own triangles",
           "", between(0, 0.5)},
          o.noise);
  v.visit({"motion_deg", "How far the object is turned between steps, at most", "degrees", between(0, 180)},
          o.motion_deg);
  v.visit({"motion", "How far the object is moved between steps, at most", "mm", at_least(0)}, o.motion_mm);
  v.visit({"highlights", "Strength of the polish; 1 = bright copper, 0 = diffuse", "", between(0, 10)}, o.highlights);
  v.visit({"shadows", "Whether the object casts shadows"}, o.shadows);
  v.visit({"ambient", "What a white surface shows with all lights off", "", between(0, 1)}, o.ambient);
  v.visit({"drift", "Standard deviation of exposure and white balance from step to step", "", between(0, 0.5)},
          o.drift);
  v.visit({"metal",
           "Bare copper is metal, which reflects in its color and has no other light; `highlights` then do nothing"},
          o.metal);
  v.visit({"relief", "How high the patina grows by the end, about", "mm", at_least(0)}, o.relief_mm);
  v.visit({"exact", "Turn all disturbances off: no noise, motion, highlights, shadows, ambient light or drift"},
          o.exact);
  v.visit({"transforms", "The project says how the object was moved, so that nothing has to be registered"},
          o.transforms);
  v.visit({"seed", "Seed of every random choice", "", at_least(0)}, o.seed);
}

MoldOptions checked_mold(MoldOptions o) {
  check_ranges(o);
  if (o.scan_spacing_mm > o.radius_mm / 10.0 || o.scan_spacing_mm < o.radius_mm / 2000.0) {
    throw InvalidInput("scan_spacing: must be between a 10th and a 2000th of `radius`");
  }
  if (o.relief_mm > o.radius_mm / 60.0) {
    throw InvalidInput("relief: must be at most a 60th of `radius`, " + short_number_text(o.radius_mm / 60.0) + " mm");
  }
  if (o.exact) {
    o.scan_noise_mm = o.noise = o.motion_deg = o.motion_mm = o.highlights = o.ambient = o.drift = 0.0;
    o.shadows = false;
  }
  return o;
}

double mold_lobe(const MoldLook& look, const Vec3& normal, const Vec3& to_light, const Vec3& to_camera) {
  if (!(look.specular > 0.0) || normal.dot(to_light) <= 0.0 || normal.dot(to_camera) <= 0.0) return 0.0;
  const double cosine = std::min(1.0, normal.dot((to_light + to_camera).normalized())), cosine2 = cosine * cosine;
  if (cosine <= 0.0) return 0.0;
  const double alpha2 = std::pow(look.roughness, 4);
  return look.specular * std::exp((1.0 - 1.0 / cosine2) / alpha2) /
         (4.0 * std::numbers::pi * alpha2 * cosine2 * cosine2);
}

Mold::Mold(const MoldOptions& options, const RunControl& control)
    : options_(options),
      coarse_(static_cast<std::uint64_t>(options.seed), kMottle, 2.2, 2.2, 0.16, 0.16),
      fine_(static_cast<std::uint64_t>(options.seed), kMottle + 1, 2.2, 2.2, 0.05, 0.05) {
  const double radius = options_.radius_mm;
  for (int i = 0; i < options_.num_dents; ++i) {
    RandomStream random(static_cast<std::uint64_t>(options_.seed), static_cast<std::uint64_t>(i), kDents);
    const double r = radius * (0.15 + 0.65 * random.uniform()), angle = 2.0 * std::numbers::pi * random.uniform();
    const double depth = radius * (0.007 + 0.012 * random.uniform()),
                 width = radius * (0.045 + 0.05 * random.uniform());
    dents_.push_back({r * std::cos(angle), r * std::sin(angle), depth, width});
  }
  HeightField field;
  curvature_spacing_ = radius * kCurvatureGrid;
  const int half = static_cast<int>(std::floor(1.0 / kCurvatureGrid)), size = 2 * half + 1;
  field.height_mm = Image<double>(size, size);
  field.seen = ImageU8(size, size);
  field.spacing_mm = curvature_spacing_;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const double x = (column - half) * curvature_spacing_, y = (half - row) * curvature_spacing_;
      if (std::hypot(x, y) > radius) continue;
      field.seen.at(column, row) = 255;
      field.height_mm.at(column, row) = bare_height(x, y);
    }
  }
  curvature_ = height_curvature(field, curvature_width_mm(), control);
  const Percentiles ends = percentiles(curvature_, field.seen, 0.02, 0.98);
  curvature_low_ = static_cast<double>(ends.low);
  curvature_high_ = std::max(static_cast<double>(ends.high), curvature_low_ + 1e-9);
}

double Mold::height(double x, double y, double time_d) const { return bare_height(x, y) + growth(x, y, time_d); }

double Mold::bare_height(double x, double y) const {
  const double radius = options_.radius_mm, u = std::hypot(x, y) / radius;
  const int n = options_.num_spokes;
  // The wall's outline is scalloped, one lobe between two spokes.
  const double wave = n > 0 && u > 1e-6 ? std::cos(n * std::atan2(y, x)) : 0.0;
  const double lobed = u * (1.0 + 0.05 * wave * smoother_step(0.15, 0.45, u) * (1.0 - smoother_step(0.80, 0.92, u)));
  double z = kHeight * (1.0 - smoother_step(kTopOfWall, kFootOfWall, lobed));
  z -= 0.13 * bump(std::pow(u / 0.17, 2));  // The pit in the middle,
  z += 0.035 * bump((u - 0.215) / 0.045);   // its rim,
  z += 0.040 * bump((u - 0.945) / 0.030);   // the rolled rim outside,
  z -= 0.020 * bump((u - 0.855) / 0.030);   // the groove inside of it.
  double spokes = 0.0;
  const double along = smoother_step(0.26, 0.36, u) * (1.0 - smoother_step(0.74, 0.84, u));
  if (along > 0.0) {
    for (int k = 0; k < n; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k + 0.5) / n, cosine = std::cos(angle), sine = std::sin(angle);
      const double ahead = (x * cosine + y * sine) / radius, aside = (y * cosine - x * sine) / radius;
      if (ahead > 0.0) spokes += bump(aside / 0.033);
    }
  }
  z += 0.045 * along * spokes;
  z *= radius;
  for (const Dent& d : dents_) z -= d.depth * bump(std::hypot(x - d.x, y - d.y) / d.width);
  return z;
}

Vec3 Mold::normal(double x, double y, double time_d) const {
  const double e = kNormalStep * options_.radius_mm / 60.0;
  const double dx = (height(x + e, y, time_d) - height(x - e, y, time_d)) / (2.0 * e),
               dy = (height(x, y + e, time_d) - height(x, y - e, time_d)) / (2.0 * e);
  return Vec3(-dx, -dy, 1.0).normalized();
}

double Mold::relief(double x, double y, double time_d) const {
  const Vec3 from(x, y, height(x, y)), along = normal(x, y);
  double risen = 0.0;
  for (int i = 0; i < 8; ++i) {  // Newton's steps on the line.
    const Vec3 p = from + risen * along, slope = normal(p.x(), p.y(), time_d);
    risen -= (p.z() - height(p.x(), p.y(), time_d)) * slope.z() / std::max(1e-3, along.dot(slope));
  }
  return risen;
}

Mesh Mold::mesh(double spacing_mm, double time_d) const {
  const int half = static_cast<int>(std::ceil(options_.radius_mm / spacing_mm)), size = 2 * half + 1;
  Mesh mesh;
  Image<int> index(size, size, 1, -1);
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      // Corners beyond the disc are drawn in to its border.
      double x = (column - half) * spacing_mm, y = (half - row) * spacing_mm;
      const double r = std::hypot(x, y), limit = options_.radius_mm;
      if (r > limit + spacing_mm) continue;
      if (r > limit) {
        x *= limit / r;
        y *= limit / r;
      }
      index.at(column, row) = static_cast<int>(mesh.positions.size());
      mesh.positions.emplace_back(x, y, height(x, y, time_d));
      mesh.normals.push_back(normal(x, y, time_d));
    }
  }
  const auto add = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0) return;
    const auto at = [&](int i) -> const Vec3& { return mesh.positions[i]; };
    if (!((at(b) - at(a)).cross(at(c) - at(a)).z() > 1e-4 * spacing_mm * spacing_mm)) return;
    mesh.triangles.push_back({a, b, c});
  };
  for (int row = 0; row + 1 < size; ++row) {
    for (int column = 0; column + 1 < size; ++column) {
      const int a = index.at(column, row + 1), b = index.at(column + 1, row + 1), c = index.at(column + 1, row),
                d = index.at(column, row);
      add(a, b, c);
      add(a, c, d);
    }
  }
  mesh.normal_triangles = mesh.triangles;
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces = {{}};
  return mesh;
}

}  // namespace patinate::datasets
