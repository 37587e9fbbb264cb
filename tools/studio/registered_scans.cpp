#include "tools/studio/registered_scans.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/scan_mesh.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "tools/studio/mesh_glb.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostTriangles = 3'000'000, kMaxShownPoints = 1'500'000;

RigidTransform transform_of(const JsonReader& json) {
  Eigen::Matrix4d matrix;
  int row = 0;
  for (const JsonReader& numbers : json.elements(4)) {
    const std::vector<double> values = numbers.numbers(4);
    for (int c = 0; c < 4; ++c) matrix(row, c) = values[c];
    ++row;
  }
  if (row != 4) json.fail("4 rows");
  return rigid_transform(matrix);
}

/// The scan's file where it may be shown: the one that was read, or the moved copy beside the poses.
void find_file(const fs::path& place, const ServedFolder& folder, const std::optional<fs::path>& recorded,
               PlacedScan& scan) {
  std::error_code error;
  if (recorded) {
    const fs::path path = fs::canonical(*recorded, error);
    const std::string name = error ? "" : folder.name_of(path);
    if (!name.empty()) scan.file = folder.find(name);
  }
  if (scan.file) return;
  if (const fs::path moved = (place / "scans" / scan.name).replace_extension(".ply");
      fs::is_regular_file(moved, error)) {
    scan.file = folder.find_below(place, moved.lexically_relative(place).string());
    scan.reference_from_file = {};
  }
  if (scan.file) return;
  scan.problem = recorded ? "its file is not below the folder that is shown"
                          : "registered by an earlier version, which kept no path; register again to see it";
}

PlacedScan read_scan(JsonReader json, const fs::path& place, const ServedFolder& folder) {
  PlacedScan scan;
  scan.name = json.member("file").string();
  scan.status = json.member("status").string();
  scan.residual = json.member("residual").number(at_least(0));
  scan.overlap = json.member("overlap").number(between(0, 1));
  const JsonReader partner = json.member("partner");
  if (partner.is_string()) scan.partner = partner.string();
  const std::optional<fs::path> recorded = json.has("path") ? std::optional(json.member("path").path()) : std::nullopt;
  const JsonReader matrix = json.member("matrix");
  if (matrix.is_null()) {
    scan.problem = "it has no place";
    return scan;
  }
  scan.reference_from_file = transform_of(matrix);
  find_file(place, folder, recorded, scan);
  return scan;
}

std::string whole_text(const PlacedScan& scan, const RegisteredScans& all) {
  const std::string unit = all.unit.empty() ? "" : " " + all.unit;
  std::string text = scan.name == all.reference ? "the reference" : scan.status;
  if (!scan.partner.empty()) {
    text += ", RMS " + short_number_text(rounded(scan.residual, 3)) + unit + ", overlap " + percent_text(scan.overlap) +
            " with " + scan.partner;
  }
  return text + (scan.problem.empty() ? "" : "; not shown: " + scan.problem);
}

/// Every n-th point.
std::vector<Vec3> thinned(const std::vector<Vec3>& points, std::size_t n) {
  std::vector<Vec3> some;
  for (std::size_t i = 0; i < points.size(); i += n) some.push_back(points[i]);
  return some;
}

}  // namespace

RegisteredScans read_registration(const fs::path& place, const ServedFolder& folder) {
  const fs::path file = place / "registration.json";
  Json root = load_json(file);
  update_spelling(root, 1, {{"free_motions", "unconstrained_dofs"}});
  JsonReader json(file.string(), root);
  json.expect_format("patinate.registration", 2);
  RegisteredScans registration;
  registration.reference = json.member("reference").string();
  const JsonReader unit = json.member("unit");
  if (unit.is_string()) registration.unit = unit.string();
  for (const JsonReader& scan : json.member("scans").elements(10'000))
    registration.scans.push_back(read_scan(scan, place, folder));
  return registration;
}

Json scans_json(const RegisteredScans& registration) {
  Json list = Json::array();
  for (const PlacedScan& scan : registration.scans) {
    list.push_back({{"name", scan.name},
                    {"status", scan.status},
                    {"residual", scan.residual},
                    {"overlap", scan.overlap},
                    {"partner", scan.partner.empty() ? Json(nullptr) : Json(scan.partner)},
                    {"is_reference", scan.name == registration.reference},
                    {"is_shown", scan.file.has_value()},
                    {"text", whole_text(scan, registration)}});
  }
  return list;
}

std::string registered_scans_glb(const RegisteredScans& registration, const RunControl& control) {
  std::vector<PointCloud> clouds;
  std::vector<std::string> names;
  std::size_t num_triangles = 0, num_points = 0;
  for (const PlacedScan& scan : registration.scans) {
    control.throw_if_stopped();
    if (!scan.file) continue;
    clouds.push_back(moved(read_point_cloud(*scan.file), scan.reference_from_file));
    names.push_back(scan.name);
    if (clouds.back().triangles.empty() && clouds.back().grid)
      clouds.back().triangles = mesh_of_scan(clouds.back()).triangles;
    num_triangles += clouds.back().triangles.size();
    num_points += clouds.back().points.size();
  }
  if (clouds.empty()) throw CannotComplete("none of the scans lies below the folder that is shown");
  Mesh all;
  std::vector<MeshPart> parts;
  const bool are_surfaces = num_triangles <= kMostTriangles;
  const std::size_t every = std::max<std::size_t>(1, (num_points + kMaxShownPoints - 1) / kMaxShownPoints);
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    PointCloud& cloud = clouds[k];
    parts.push_back({.name = names[k], .triangles = {}, .points = {}});
    if (!are_surfaces || cloud.triangles.empty()) {
      parts.back().points = thinned(cloud.points, every);
      continue;
    }
    const int first = static_cast<int>(all.positions.size());
    all.positions.insert(all.positions.end(), cloud.points.begin(), cloud.points.end());
    for (const Triangle& t : cloud.triangles) {
      parts.back().triangles.push_back(all.num_triangles());
      all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    cloud = {};
  }
  all.surfaces.resize(1);
  all.triangle_surface.assign(all.triangles.size(), 0);
  return mesh_glb({.mesh = with_normals(std::move(all)), .parts = std::move(parts)},
                  0.001 * find_mm_per_unit(registration.unit).value_or(1.0));
}

}  // namespace patinate::studio
