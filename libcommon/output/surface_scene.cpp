#include "libcommon/output/surface_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "libcommon/core/parallel.h"
#include "libcommon/geometry/mesh_append.h"
#include "libcommon/geometry/mesh_refine.h"
#include "libcommon/output/hit_corners.h"
#include "libcommon/output/relief.h"
#include "libcommon/output/render_light.h"
#include "libcommon/output/sampling.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr int kMaxReliefTriangles = 1'200'000;
// Lamps graze flat triangles where normals say that the surface is round: dark facets in dents, and corners at
// outlines.
constexpr double kCurvedEdge = 1.0 / 150;  // Longest edge, in diagonals.
constexpr int kMaxCurvedTriangles = 200'000;
constexpr double kLeafSpecular = 0.04;
constexpr double kLeafRoughness = 0.7;
constexpr double kMinFacing = 0.02;  // Normals are bent to face the viewer by this.

void check_channels(const ImageF& map, int channels, const char* what) {
  if (!map.empty() && map.channels() != channels) throw InvalidInput(std::string("render: ") + what);
}

/// Of a surface, or of its pieces.
void check_maps(const SurfaceMaps& maps) {
  if (maps.color.empty()) throw InvalidInput("render: the texture is empty");
  check_channels(maps.normals, 3, "normals have three numbers a texel");
  check_channels(maps.roughness, 1, "a roughness is one number a texel");
  check_channels(maps.metalness, 1, "a metalness is one number a texel");
  check_channels(maps.height, 1, "a height is one number a texel");
  check_channels(maps.wetness, 1, "a wetness is one number a texel");
  check_channels(maps.plants, 1, "an amount of plants is one number a texel");
}

/// Ambient visibility of pieces, where they come out of the surface too. The end of a piece that is inside the surface
/// is dark; what is seen beside it would be darkened by it. It gets the largest value beside it.
/// @param all  Of the surface's triangles, and behind them of the pieces'.
std::vector<float> visibility_of_pieces(const Mesh& pieces, const Mesh& surface, const RayScene& all, int num_surface,
                                        double diagonal, const RenderOptions& options, const RunControl& control) {
  std::vector<float> open = occlusion_at_vertices(pieces, all, diagonal, options, control);
  const std::vector<Vec3> normals = vertex_normals(pieces);
  const double depth = 0.01 * diagonal;  // Far more than pieces go in, and less than a body is thick.
  std::vector<char> is_inside(open.size(), 0);
  parallel_for(static_cast<std::int64_t>(open.size()), 1024, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::optional<RayHit> hit = all.first_hit(pieces.positions[i], normals[i], kRayOffset * diagonal, depth);
      is_inside[i] = hit && hit->triangle < num_surface && area_vector(surface, hit->triangle).dot(normals[i]) > 0.0;
    }
  });
  const std::vector<float> before = open;
  for (const Triangle& t : pieces.triangles) {
    for (const int i : t) {
      for (const int k : t) {
        if (is_inside[i] != 0 && is_inside[k] == 0) open[i] = std::max(open[i], before[k]);
      }
    }
  }
  return open;
}

void check_pieces(const SurfacePieces& pieces) {
  for (const SurfaceMaps& maps : pieces.maps) check_maps(maps);
  const auto is_known = [&](std::uint8_t material) { return material < pieces.maps.size(); };
  if (!pieces.mesh.has_uvs() || pieces.materials.size() != pieces.mesh.triangles.size() ||
      !std::all_of(pieces.materials.begin(), pieces.materials.end(), is_known))
    throw InvalidInput("render: pieces have UVs, and maps for every triangle");
}

Vec3 color_at(const ImageF& map, const Vec2& uv) {
  const std::array<double, 3> c = texture_at(map, uv.x(), uv.y());
  return {c[0], c[1], c[2]};
}

double value_at(const ImageF& map, const Vec2& uv, double otherwise) {
  return map.empty() ? otherwise : texture_at(map, uv.x(), uv.y())[0];
}

}  // namespace

SurfaceShape::SurfaceShape(const Mesh& given, const ImageF& height, const RenderOptions& options,
                           const RunControl& control)
    : mesh(refined_for_occlusion(with_shared_positions(with_normals(given)), options)),
      box(bounding_box(given)),
      texels_across(height.width()),
      texels_down(height.height()),
      ground(mesh, box, options.up) {
  const RayScene scene(mesh);
  open = occlusion_at_vertices(mesh, scene, box.diagonal(), options, control.part(0.0, 0.7));
  if (options.ground) ground.find_visibility(scene, options, control.part(0.7, 1.0));
  std::vector<std::array<int, 2>> parents;
  mesh = refine_edges(std::move(mesh), kCurvedEdge * box.diagonal(),
                      std::max(kMaxCurvedTriangles, mesh.num_triangles()), RefineShape::Curved, parents);
  for (const auto& [a, b] : parents)
    open.push_back(0.5f * (open[static_cast<std::size_t>(a)] + open[static_cast<std::size_t>(b)]));
  if (!height.empty()) mesh = refined_to_texels(std::move(mesh), height, kMaxReliefTriangles, open);
}

const ImageF& SurfaceScene::heights(const SurfaceMaps& maps, const SurfaceOptions& surface) {
  static const ImageF none;
  return surface.relief > 0.0 ? maps.height : none;
}

SurfaceScene::SurfaceScene(const Mesh& mesh, std::shared_ptr<const SurfaceShape> shape, SurfaceMaps maps,
                           const RenderOptions& options, const SurfaceOptions& surface, const RunControl& control)
    : maps_(std::move(maps)),
      options_(options),
      surface_(surface),
      shape_(std::move(shape)),
      mesh_(shape_->mesh),
      open_(shape_->open) {
  check_maps(maps_);
  if (!mesh.has_uvs()) throw InvalidInput("render: the mesh has no UVs; unwrap it first");
  const std::vector<Plant> plants = find_plants(mesh, maps_, options, surface);
  const ImageF& height = heights(maps_, surface);
  if (!height.empty()) {
    const ReliefNormals normals = maps_.normals.empty() ? ReliefNormals::Turned : ReliefNormals::Kept;
    mesh_ = displaced(std::move(mesh_), height, surface.relief, normals);
  }
  if (maps_.pieces && !maps_.pieces->mesh.triangles.empty()) add_pieces(control);
  if (!maps_.normals.empty()) tangents_ = corner_tangents(mesh_);
  plants_ = add_plants(mesh_, plants, open_);
  scene_.emplace(mesh_);
}

void SurfaceScene::add_pieces(const RunControl& control) {
  check_pieces(*maps_.pieces);
  const Mesh pieces = with_normals(maps_.pieces->mesh);
  const std::size_t first_position = mesh_.positions.size();
  first_piece_ = mesh_.triangles.size();
  append_mesh(mesh_, pieces);
  end_of_pieces_ = mesh_.triangles.size();
  const RayScene all(mesh_);
  const std::vector<float> open =
      visibility_of_pieces(pieces, mesh_, all, static_cast<int>(first_piece_), diagonal(), options_, control);
  open_.resize(first_position);
  open_.insert(open_.end(), open.begin(), open.end());
}

const SurfaceMaps& SurfaceScene::maps_of(std::size_t triangle) const {
  if (triangle < first_piece_ || triangle >= end_of_pieces_) return maps_;
  return maps_.pieces->maps[maps_.pieces->materials[triangle - first_piece_]];
}

double SurfaceScene::ray_offset() const { return kRayOffset * diagonal(); }

std::optional<SeenPoint> SurfaceScene::first_hit(const Vec3& origin, const Vec3& direction) const {
  const std::optional<RayHit> hit = scene_->first_hit(origin, direction);
  if (!hit) return std::nullopt;
  return point(*hit, direction);
}

void SurfaceScene::read_material(SeenPoint& point, const SurfaceMaps& maps, const Vec2& uv) const {
  point.color = color_at(maps.color, uv).cwiseMax(0.0);
  point.specular = maps.specular.empty() ? Vec3(Vec3::Constant(options_.specular))
                                         : Vec3(color_at(maps.specular, uv).cwiseMax(0.0).cwiseMin(1.0));
  point.roughness = std::clamp(value_at(maps.roughness, uv, options_.roughness), 0.05, 1.0);
  point.metalness = std::clamp(value_at(maps.metalness, uv, 0.0), 0.0, 1.0);
  point.wetness = std::clamp(value_at(maps.wetness, uv, 0.0), 0.0, 1.0);
}

void SurfaceScene::read_leaf(SeenPoint& point, std::size_t triangle, const RayHit& hit) const {
  point.color = plants_.color(triangle, hit.b1, hit.b2);
  point.specular = Vec3::Constant(kLeafSpecular);
  point.roughness = kLeafRoughness;
}

SeenPoint SurfaceScene::point(const RayHit& hit, const Vec3& direction) const {
  const std::size_t t = hit.triangle;
  const HitCorners corners = corners_of(mesh_, open_, t);
  const std::array<Vec3, 3>& p = corners.positions;
  SeenPoint point;
  point.view = -direction;
  const Vec2 at = blend(corners.uvs, hit.b1, hit.b2);
  point.face = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  // Both sides show: a surface seen from behind is lit like one that faces the viewer.
  const double side = point.face.dot(direction) > 0.0 ? -1.0 : 1.0;
  point.face *= side;
  const Vec3 smooth = blend(corners.normals, hit.b1, hit.b2).normalized();
  const auto facing = [&](const Vec3& normal) -> Vec3 {
    const Vec3 turned = side * normal;
    const double lack = kMinFacing - turned.dot(point.view);
    return lack > 0.0 ? Vec3((turned + lack * point.view).normalized()) : turned;
  };
  point.smooth = facing(smooth);
  const bool is_leaf = plants_.is_leaf(t);
  point.normal = point.smooth;
  const SurfaceMaps& maps = maps_of(t);
  if (!maps.normals.empty() && !is_leaf && !tangents_.tangent.empty()) {
    const Vec3 n = color_at(maps.normals, at);
    point.normal =
        facing(mapped_normal(tangents_, hit, smooth, Vec3(surface_.relief * n.x(), surface_.relief * n.y(), n.z())));
  }
  point.open = options_.occlusion_samples > 0 ? blend(corners.open, hit.b1, hit.b2) : 1.0;
  point.place = smooth_place(corners, hit, side) + ray_offset() * point.face;
  if (is_leaf) {
    read_leaf(point, t, hit);
  } else {
    read_material(point, maps, at);
  }
  return point;
}

}  // namespace patinate
