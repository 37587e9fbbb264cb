// The view that all steps are brought into.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/project/scan_control.h"
#include "capture/relit/relit_work.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/height_field.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr double kDefaultWidthShare = 0.02;  ///< Share of the scan's diagonal, as accessibility of meshes.
constexpr double kSpacingShare = 0.2;        ///< Share of the width: distance between heights.
constexpr double kReached = 0.01;            ///< A light that reaches a smaller share of the surface is somewhere else.

/// @throws IoError naming the light that stands behind the surface.
void check_lights_reach(const RelitProject& project, const ScanView& view) {
  for (std::size_t i = 0; i < project.lights.size(); ++i) {
    std::int64_t num_reached = 0;
    for (int y = 0; y < view.seen.height(); ++y) {
      for (int x = 0; x < view.seen.width(); ++x) {
        if (view.seen.at(x, y) == 0) continue;
        num_reached +=
            pixel_vector(view.normal, x, y).dot(direction_to(project.lights[i], pixel_vector(view.position_mm, x, y))) >
            0.0;
      }
    }
    if (static_cast<double>(num_reached) >= kReached * static_cast<double>(view.num_seen)) continue;
    throw IoError(project.file.string(),
                  "/lights/" + std::to_string(i) +
                      ": stands behind the surface that the camera sees: it reaches none of it; check its position" +
                      " and the scanner's axes");
  }
}

/// Curvature of the height function toward the camera, at every pixel of the view.
ImageF view_curvature(const Mesh& mesh, const RayScene& scene, const ScanView& view, const Vec3& viewer,
                      double width_mm, const RunControl& control) {
  const HeightField field = height_field(mesh, scene, viewer, kSpacingShare * width_mm, control.part(0.0, 0.4));
  const ImageF curvature = height_curvature(field, std::max(width_mm, 0.5 * field.spacing_mm), control.part(0.4, 1.0));
  ImageF out(view.seen.width(), view.seen.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      if (view.seen.at(x, y) != 0)
        out.at(x, y) =
            static_cast<float>(sample_field(field, curvature, pixel_vector(view.position_mm, x, y)).value_or(0.0));
    }
  }
  return out;
}

Json vectors_json(const std::vector<Vec3>& list) {
  Json json = Json::array();
  for (const Vec3& v : list) json.push_back({v.x(), v.y(), v.z()});
  return json;
}

}  // namespace

void run_relit_reference(const RelitWork& work, const fs::path& folder, const RunControl& control) {
  const RelitProject& project = work.project;
  RelitReference reference;
  Json facts = Json::object();
  if (project.has_shape()) {
    const RelitStep& step = project.steps[project.reference];
    const Mesh mesh = read_step_mesh(project, step);
    const RayScene scene(mesh);
    reference.view = view_scan(mesh, scene, project.camera_mm, control.part(0.0, 0.4));
    const ScanView& view = reference.view;
    if (view.num_seen == 0) {
      const fs::path file = step.ready ? step.ready->position : *step.scan;
      throw IoError(file.string(), "the camera does not see the scan: " + where_it_lies(mesh, project.camera_mm) +
                                       "; check `unit` and the camera's pose");
    }
    check_lights_reach(project, view);
    const Vec3 viewer = -project.camera_mm.parameters().rotation.row(2).transpose();
    const double width = work.options.scan.scale_mm.value_or(kDefaultWidthShare * bounding_box(mesh).diagonal());
    const ImageF curvature = view_curvature(mesh, scene, view, viewer, width, control.part(0.4, 0.8));
    fs::create_directories((folder / relit_curvature_file()).parent_path());
    write_exr(folder / relit_curvature_file(), curvature, {"Y"}, ExrDepth::Float);
    facts["width_mm"] = width;
    facts["from_behind"] = view.num_from_behind;
    ImageF height(view.seen.width(), view.seen.height());
    const double floor = bounding_box(mesh).center().dot(viewer) - 0.5 * bounding_box(mesh).diagonal();
    for (int y = 0; y < height.height(); ++y) {
      for (int x = 0; x < height.width(); ++x) {
        if (view.seen.at(x, y) != 0)
          height.at(x, y) = static_cast<float>(pixel_vector(view.position_mm, x, y).dot(viewer) - floor);
      }
    }
    HistoryWriter::write_map(folder, "position", view.position_mm);
    HistoryWriter::write_map(folder, "normal", view.normal);
    HistoryWriter::write_map(folder, "height", height);
    HistoryWriter::write_map(folder, "texel_size", view.texel_size_mm);
  }
  find_patch_target(project, reference);
  facts["patch_target"] = vectors_json(reference.patch_target);
  facts["is_patch_absolute"] = reference.is_patch_absolute;
  fs::create_directories((folder / relit_reference_file()).parent_path());
  save_json(folder / relit_reference_file(), facts);
  control.report(1.0);
}

const RelitReference& RelitWork::reference(const fs::path& folder) const {
  const std::lock_guard lock(mutex_);
  if (reference_) return *reference_;
  RelitReference loaded;
  const int width = project.width(), height = project.height();
  loaded.view.seen = ImageU8(width, height, 1, project.has_shape() ? 0 : 255);
  if (project.has_shape()) {
    loaded.view.position_mm = read_channels(folder / HistoryWriter::map_file("position"), {"X", "Y", "Z"});
    loaded.view.normal = read_channels(folder / HistoryWriter::map_file("normal"), {"X", "Y", "Z"});
    loaded.view.texel_size_mm = read_gray(folder / HistoryWriter::map_file("texel_size"));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!(loaded.view.texel_size_mm.at(x, y) > 0.0f)) continue;
        loaded.view.seen.at(x, y) = 255;
        ++loaded.view.num_seen;
      }
    }
  }
  const Json facts = load_json(folder / relit_reference_file());
  loaded.view.num_from_behind = facts.value("from_behind", std::int64_t{0});
  for (const Json& v : facts.at("patch_target"))
    loaded.patch_target.emplace_back(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>());
  loaded.is_patch_absolute = facts.at("is_patch_absolute").get<bool>();
  reference_ = std::move(loaded);
  return *reference_;
}

}  // namespace patinate::capture
