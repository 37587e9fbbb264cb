#include "patinate/output/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "libcommon/core/parallel.h"
#include "libcommon/output/backdrop.h"
#include "libcommon/output/render_light.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::array<std::string_view, 3> kBackdropNames = {"studio", "white", "environment"};
constexpr std::int64_t kMaxSamples = std::int64_t{1} << 28;
constexpr std::int64_t kRowsAChunk = 4;

void check_detail(const SurfaceDetail& detail) {
  if (!detail.normals.empty() && detail.normals.channels() != 3)
    throw InvalidInput("render: normals have three numbers a texel");
  if (!detail.roughness.empty() && detail.roughness.channels() != 1)
    throw InvalidInput("render: a roughness is one number a texel");
}

}  // namespace

void check_render_options(const RenderOptions& o) {
  check_ranges(o);
  if (o.distance && !(*o.distance > 0.0 && std::isfinite(*o.distance)))
    throw InvalidInput("render: the camera's distance is not above 0");
  if (o.target && !o.target->allFinite()) throw InvalidInput("render: the camera's target is not finite");
  const int side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(o.samples))));
  if (std::int64_t{o.width} * o.height * side * side > kMaxSamples) {
    throw InvalidInput("render: width x height x samples is above 2^28; use a smaller picture or fewer samples");
  }
}

void describe(OptionVisitor& v, RenderOptions& o) {
  v.visit({"width", "Width of the picture", "px", between(16, 8192)}, o.width);
  v.visit({"height", "Height of the picture", "px", between(16, 8192)}, o.height);
  v.visit({"samples", "Rays per pixel, rounded up to a square", "", between(1, 256)}, o.samples);
  v.visit({"azimuth", "Direction from which the camera looks, around the up axis", "deg", between(-3600, 3600)},
          o.azimuth_deg);
  v.visit({"elevation", "How far the camera looks down", "deg", between(-90, 90)}, o.elevation_deg);
  v.visit({"fov", "Larger of the two fields of view", "deg", between(1, 120)}, o.fov_deg);
  v.visit({"zoom", "1 fits the mesh into the picture", "", above(0)}, o.zoom);
  v.visit({"margin", "Share of the picture left free around the mesh", "", between(0, 0.9)}, o.margin);
  v.visit_choice({"up", "Axis of the mesh that points up"}, o.up, kUpAxisNames);
  v.visit({"light_azimuth", "Direction of the light, from the camera's", "deg", between(-3600, 3600)},
          o.light_azimuth_deg);
  v.visit({"light_elevation", "Height of the light", "deg", between(-90, 90)}, o.light_elevation_deg);
  v.visit({"light_size", "Half angle under which the light is seen; 0 = hard shadows", "deg", between(0, 60)},
          o.light_size_deg);
  v.visit({"light_distance",
           "From the middle of the mesh, or --target, to the light, in the mesh's unit: a near lamp, whose light falls "
           "off with the square of the distance; 0 = far, its rays are parallel",
           "", between(0, 1e9)},
          o.light_distance);
  v.visit({"light", "Radiance of a white surface that faces the light", "", between(0, 1000)}, o.light);
  v.visit({"ambient", "Radiance of a white surface from light all around", "", between(0, 1000)}, o.ambient);
  v.visit({"ambient_gradient", "Share by which surfaces that face down get less of it", "", between(0, 1)},
          o.ambient_gradient);
  v.visit({"occlusion_samples", "Ambient rays per vertex; 0 = none", "", between(0, 4096)}, o.occlusion_samples);
  v.visit({"occlusion_reach", "Length of ambient rays in diagonals of the bounding box", "", above(0)},
          o.occlusion_reach);
  v.visit({"specular", "Reflectance of the coat at normal incidence", "", between(0, 1)}, o.specular);
  v.visit({"roughness", "Roughness of the coat (GGX)", "", between(0.05, 1)}, o.roughness);
  v.visit({"ground", "The backdrop catches shadows"}, o.ground);
  v.visit_choice({"backdrop", "What is behind the mesh"}, o.backdrop, kBackdropNames);
  v.visit({"background", "Linear gray of the studio backdrop", "", between(0, 1)}, o.background);
}

RenderView::RenderView(const Mesh& mesh, const RenderOptions& options, const RunControl& control)
    : RenderView(mesh, options, SurfaceDetail{}, control) {}

RenderView::RenderView(const Mesh& mesh, const RenderOptions& options, const SurfaceDetail& detail,
                       const RunControl& control) {
  check_render_options(options);
  check_detail(detail);
  if (!mesh.has_uvs()) throw InvalidInput("render: the mesh has no UVs; unwrap it first");
  const Box box = bounding_box(mesh);
  if (!(box.diagonal() > 0.0) || !std::isfinite(box.diagonal())) throw InvalidInput("render: the mesh has no extent");
  const int side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(options.samples))));
  width_ = options.width;
  height_ = options.height;
  num_samples_ = side * side;
  background_ = ImageF(width_, height_);

  const OrbitCamera camera = fitted_camera(mesh, options);
  const LitMesh lit(mesh, options, detail, camera, control.part(0.0, 0.4));
  struct Row {
    std::vector<Sample> samples;
    std::vector<std::uint32_t> count;
  };
  std::vector<Row> rows(static_cast<std::size_t>(height_));
  parallel_for(height_, kRowsAChunk, control.part(0.4, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y) {
      Row& row = rows[y];
      for (int x = 0; x < width_; ++x) {
        control.throw_if_stopped();  // Rows may be long, and pixels of many samples.
        const std::size_t before = row.samples.size();
        double background = 0.0;
        for (int k = 0; k < num_samples_; ++k) {
          const int column = k % side, line = k / side;
          const double px = x + (column + 0.5) / side, py = y + (line + 0.5) / side;
          const Vec3 direction = camera.direction(px / width_, py / height_);
          const LitPoint point = lit.look(camera.position, direction, x, y, k, num_samples_);
          if (point.is_hit) {
            row.samples.push_back({static_cast<float>(point.uv.x()), static_cast<float>(point.uv.y()),
                                   static_cast<float>(point.diffuse), static_cast<float>(point.specular)});
          } else {
            background += point.diffuse * static_cast<double>(backdrop(options, px / width_, py / height_));
          }
        }
        row.count.push_back(static_cast<std::uint32_t>(row.samples.size() - before));
        background_.at(x, y) = static_cast<float>(background / num_samples_);
      }
    }
  });
  num_before_.reserve(static_cast<std::size_t>(background_.num_pixels()) + 1);
  num_before_.push_back(0);
  for (const Row& row : rows) {
    for (const std::uint32_t count : row.count) num_before_.push_back(num_before_.back() + count);
    samples_.insert(samples_.end(), row.samples.begin(), row.samples.end());
  }
}

ImageF RenderView::shade(const ImageF& texture, const RunControl& control) const {
  if (texture.empty()) throw InvalidInput("render: the texture is empty");
  ImageF picture(width_, height_, 3);
  parallel_for(height_, kRowsAChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y) {
      for (int x = 0; x < width_; ++x) {
        const std::size_t pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
        std::array<double, 3> sum{};
        for (std::uint32_t i = num_before_[pixel]; i < num_before_[pixel + 1]; ++i) {
          const Sample& s = samples_[i];
          const std::array<double, 3> albedo = texture_at(texture, static_cast<double>(s.u), static_cast<double>(s.v));
          for (std::size_t c = 0; c < 3; ++c) {
            sum[c] += std::max(0.0, albedo[c]) * static_cast<double>(s.diffuse) + static_cast<double>(s.specular);
          }
        }
        for (int c = 0; c < 3; ++c) {
          picture.at(x, y, c) = background_.at(x, y) + static_cast<float>(sum[c] / num_samples_);
        }
      }
    }
  });
  return picture;
}

ImageU8 RenderView::coverage() const {
  ImageU8 mask(width_, height_);
  for (std::size_t p = 0; p < mask.values().size(); ++p)
    mask.values()[p] = num_before_[p + 1] > num_before_[p] ? 255 : 0;
  return mask;
}

ImageF render(const Mesh& mesh, const ImageF& texture, const RenderOptions& options, const RunControl& control) {
  return RenderView(mesh, options, control.part(0.0, 0.95)).shade(texture, control.part(0.95, 1.0));
}

}  // namespace patinate
