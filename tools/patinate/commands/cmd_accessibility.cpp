#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/mesh/mesh_source.h"
#include "app/request/usage_error.h"
#include "capture/relit/relit_view.h"
#include "libcommon/controls/height_accessibility.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/mesh_key.h"
#include "libcommon/geometry/scan_mesh.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/declared_options.h"

namespace patinate::cli {

namespace {

namespace fs = std::filesystem;

constexpr const char* kAccessibilityManifest = "accessibility.json";

struct AccessibilityCommandOptions {
  std::array<double, 3> direction{0.0, 0.0, 1.0};
  std::string camera;
  HeightAccessibilityOptions maps;
};
void describe(OptionVisitor& v, AccessibilityCommandOptions& o) {
  v.visit({"direction", "direction from the surface to the viewer; heights are measured along it"},
          std::span<double>(o.direction));
  v.visit({"camera",
           "OpenCV calibration with a pose, in the mesh's unit: heights are along its axis, and the maps in its view"},
          o.camera);
  describe(v, o.maps);
}

/// A mesh, or a range grid as one; in mm.
Mesh load_surface(const app::MeshSource& source, double mm, CommandRun& run) {
  const std::string extension = source.path.extension().string();
  Mesh mesh;
  bool is_grid = extension == ".pcd";
  if (extension == ".ply" || is_grid) {
    const PointCloud cloud = read_point_cloud(source.path);
    is_grid = is_grid || (cloud.grid && cloud.triangles.empty());
    if (is_grid) {
      try {
        mesh = mesh_of_scan(cloud);
      } catch (const InvalidInput& e) {
        throw IoError(source.path.string(), e.what());
      }
    }
  }
  if (!is_grid) mesh = app::load_mesh(source, words_of(run));
  scale_mesh(mesh, mm);
  return mesh;
}

/// The grid's values where a camera's pixels see them; the grid's own without a camera.
ImageF in_view(const HeightAccessibility& found, const AccessibilityDefinition& definition,
               const std::optional<capture::ScanView>& view) {
  if (!view) return definition.values;
  ImageF out(view->seen.width(), view->seen.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      if (view->seen.at(x, y) == 0) continue;
      const std::span<const float> p = view->position_mm.pixel(x, y);
      const Vec3 point(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
      out.at(x, y) = static_cast<float>(sample_field(found.field, definition.values, point).value_or(0.0));
    }
  }
  return out;
}

ImageF picture(const ImageF& values, const ImageU8& mask, double low, double high) {
  ImageF out(values.width(), values.height(), 3);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const float v =
          static_cast<float>(std::clamp((static_cast<double>(values.at(x, y)) - low) / (high - low), 0.0, 1.0));
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = mask.at(x, y) == 0 ? 0.03f : v * v;  // Even steps to the eye.
    }
  }
  return out;
}

void write_page(const fs::path& folder, const std::string& name, const Json& report) {
  HtmlPage page("Accessibility of " + name);
  page.paragraph(
      "How hard each place is to reach, in three definitions, dark to bright from easy to hard. Mean curvature of the "
      "height function toward (" +
      short_number_text(report.at("viewer").at(0).get<double>()) + ", " +
      short_number_text(report.at("viewer").at(1).get<double>()) + ", " +
      short_number_text(report.at("viewer").at(2).get<double>()) + ") at a width of " +
      short_number_text(report.at("scale_mm").get<double>()) +
      " mm; share of rays that hit the surface again; 1 / radius of the largest sphere that touches from outside.");
  std::vector<HtmlPicture> pictures;
  std::vector<std::string> header{"rank correlation"};
  std::vector<std::vector<std::string>> rows;
  for (const Json& d : report.at("definitions")) {
    const std::string title = d.at("name").get<std::string>();
    header.push_back(title);
    pictures.push_back({title + ".png", title + ", " +
                                            short_number_text(rounded(d.at("range").at(0).get<double>(), 3)) + " to " +
                                            short_number_text(rounded(d.at("range").at(1).get<double>(), 3)) + " " +
                                            d.at("unit").get<std::string>()});
  }
  for (std::size_t a = 0; a < 3; ++a) {
    rows.push_back({header[a + 1]});
    for (std::size_t b = 0; b < 3; ++b)
      rows.back().push_back(
          short_number_text(std::round(100.0 * report.at("correlation").at(a).at(b).get<double>()) / 100.0));
  }
  page.pictures(pictures);
  page.table(header, rows);
  page.paragraph("1: the two say the same; 0: they have nothing to do with one another.");
  page.save(folder / "report.html");
}

void run_item(const fs::path& folder, const Mesh& mesh, const Vec3& viewer, const std::optional<Camera>& camera,
              const HeightAccessibilityOptions& options, const RunControl& control) {
  const HeightAccessibility found = height_accessibility(mesh, viewer, options, control.part(0.0, 0.95));
  std::optional<capture::ScanView> view;
  if (camera) {
    const Mesh shaded = capture::with_scan_normals(mesh);
    view = capture::view_scan(shaded, RayScene(shaded), *camera);
    if (view->num_seen == 0)
      throw InvalidInput("accessibility: the camera does not see the mesh; check --unit and its pose");
  }
  const ImageU8& mask = view ? view->seen : found.field.seen;
  write_codes(folder / "mask.png", mask);
  Json report{{"viewer", {viewer.x(), viewer.y(), viewer.z()}},
              {"scale_mm", found.scale_mm},
              {"spacing_mm", found.field.spacing_mm},
              {"view", camera ? "camera" : "orthographic"}};
  for (const AccessibilityDefinition& d : found.definitions) {
    const ImageF values = in_view(found, d, view);
    write_scaled_exr(folder / (d.name + ".exr"), values, {0.0, 1.0, d.unit});  // Physical values as they are.
    write_srgb8(folder / (d.name + ".png"), picture(values, mask, d.low, d.high));
    report["definitions"].push_back(
        {{"name", d.name}, {"file", d.name + ".exr"}, {"unit", d.unit}, {"range", {d.low, d.high}}});
  }
  report["correlation"] = found.correlation;
  save_json(folder / "maps.json", report);
  control.report(1.0);
}

}  // namespace

int cmd_accessibility(CommandRun& run) {
  app::MeshSource source;
  fs::path output;
  AccessibilityCommandOptions options;
  declare_mesh(run.line, source);
  run.line.output(
      "FOLDER", "Folder to make: three maps (EXR, physical values), pictures, report.html, accessibility.json", output);
  run.line.options(options);
  run.line.usual({"unit", "camera", "scale", "resolution", "direction"});
  run.line.example("control accessibility scan.ply -o access");
  run.line.example("control accessibility scan.ply --camera camera.yml --scale 0.8 -o access");
  if (!run.parse()) return 0;
  const double mm = app::mm_per_unit(source.unit_or_none().value_or("mm"));
  const Mesh mesh = load_surface(source, mm, run);
  std::optional<Camera> camera;
  if (!options.camera.empty()) camera = read_camera(fs::path(options.camera)).scaled(mm);
  Vec3 viewer(options.direction[0], options.direction[1], options.direction[2]);
  if (camera) viewer = -camera->parameters().rotation.row(2).transpose();
  if (!(viewer.norm() > 1e-9 && viewer.allFinite()))
    throw app::UsageError("--direction: needs a length; give x,y,z from the surface to the viewer");
  viewer.normalize();
  JobInputs inputs("accessibility", 1);
  inputs.add_content("mesh", source.path.filename().string(), mesh_content_key(mesh));
  if (camera)
    inputs.add_content("camera", fs::path(options.camera).filename().string(), ContentHash().add(camera->text()).hex());
  AccessibilityCommandOptions plain = options;
  plain.camera.clear();  // Counts by content.
  inputs.add_options(option_values(plain));
  JobPlan plan = inputs.plan(output, kAccessibilityManifest);
  JobItem item{.name = "maps", .outputs = {"mask.png", "maps.json"}, .run = {}};
  for (const char* name : {"accessibility", "ray_share", "tangent_sphere"}) {
    item.outputs.push_back(std::string(name) + ".exr");
    item.outputs.push_back(std::string(name) + ".png");
  }
  item.run = [&](const fs::path& folder, const RunControl& control) {
    run_item(folder, mesh, viewer, camera, options.maps, control);
  };
  plan.items.push_back(std::move(item));
  plan.join = [&](const fs::path& folder, const RunControl&) {
    Json report = load_json(folder / "maps.json");
    report["key"] = plan.key;
    write_page(folder, source.path.filename().string(), report);
    save_json(folder / kAccessibilityManifest, report);
  };
  const std::optional<JobStatus> status = run.make_folder(plan, "accessibility");
  if (!status) return 0;
  const Json report = load_json(output / kAccessibilityManifest);
  const auto correlation = [&](std::size_t a, std::size_t b) {
    return short_number_text(std::round(100.0 * report.at("correlation").at(a).at(b).get<double>()) / 100.0);
  };
  run.note("rank correlation with ray_share " + correlation(0, 1) + ", with tangent_sphere " + correlation(0, 2) +
           "; of those two " + correlation(1, 2));
  run.report_output(*status, output,
                    Json{{"scale_mm", report.at("scale_mm")}, {"correlation", report.at("correlation")}});
  return 0;
}

}  // namespace patinate::cli
