#include <nlohmann/json.hpp>

#include "capture/calibration/calibrate_kinds.h"
#include "capture/calibration/residual_picture.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/light_io.h"
#include "libcommon/image/response_io.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kMaxSpheres = 100;
constexpr std::size_t kMaxPhotos = 10'000;

/// One light as the description has it.
struct LightEntry {
  std::string name;
  std::filesystem::path photo;  ///< Empty when highlights are given.
  std::vector<std::optional<Vec2>> highlights;
};

MirrorSphere read_sphere(JsonReader json, double mm_per_unit, int width, int height) {
  MirrorSphere sphere;
  sphere.radius_mm = mm_per_unit * json.member("radius").number(above(0));
  if (json.has("name")) sphere.name = json.member("name").string();
  if (json.has("outline")) {
    sphere.outline_px = read_pixels(json.member("outline"));
  } else if (json.has("circle")) {
    const JsonReader circle = json.member("circle");
    const std::vector<double> v = circle.numbers(3);
    if (!(v[2] > 0)) circle.fail("[x, y, radius] with a radius > 0");
    sphere.outline_px = outline_of_circle({v[0], v[1]}, v[2]);
  } else if (json.has("mask")) {
    const std::filesystem::path path = json.member("mask").path();
    const ImageU8 mask = read_mask(path);
    if (mask.width() != width || mask.height() != height) {
      throw IoError(path.string(), "is " + size_text(mask.width(), mask.height()) + " pixels; expected " +
                                       size_text(width, height) + ", as the camera");
    }
    try {
      sphere.outline_px = outline_of_mask(mask);
    } catch (const InvalidInput& e) {
      throw IoError(path.string(), e.what());
    }
  } else {
    json.fail("a sphere with `outline`: [[x, y], ...], `circle`: [x, y, radius] or `mask`, in pixels");
  }
  json.finish();
  return sphere;
}

LightEntry read_entry(JsonReader json, std::size_t num_spheres) {
  LightEntry entry;
  if (json.is_string()) {
    entry.photo = json.path();
    entry.name = entry.photo.filename().string();
    return entry;
  }
  if (json.has("highlights")) {
    const JsonReader highlights = json.member("highlights");
    for (const JsonReader& pixel : highlights.elements(kMaxSpheres)) {
      if (pixel.is_null()) {
        entry.highlights.emplace_back();
      } else {
        const std::vector<double> v = pixel.numbers(2);
        entry.highlights.emplace_back(Vec2(v[0], v[1]));
      }
    }
    if (entry.highlights.size() != num_spheres)
      highlights.fail("a pixel or null for each of the " + std::to_string(num_spheres) + " spheres");
  }
  if (entry.highlights.empty()) entry.photo = json.member("photo").path();
  if (json.has("photo")) entry.photo = json.member("photo").path();
  entry.name = json.has("name") ? json.member("name").string() : entry.photo.filename().string();
  json.finish();
  return entry;
}

/// Highlights of a photograph on all spheres. Spheres that do not show the light are excluded, with a word; a
/// photograph in which none does is an error.
std::vector<std::optional<Vec2>> find_highlights(const LightEntry& entry, const ImageF& photo, const Camera& camera,
                                                 const std::vector<MirrorSphere>& spheres,
                                                 std::vector<std::string>& lines) {
  std::vector<std::optional<Vec2>> found;
  std::string reason;
  bool is_any = false;
  for (std::size_t s = 0; s < spheres.size(); ++s) {
    const SphereFit fit = fit_sphere(camera, spheres[s]);
    found.emplace_back();
    if (fit.status != SphereFitStatus::Converged) continue;  // Named by lights_from_spheres().
    const Highlight highlight = find_highlight(photo, camera, fit.center, spheres[s].radius_mm);
    if (highlight.status == HighlightStatus::Found) {
      found.back() = highlight.pixel;
      is_any = true;
    } else {
      reason = highlight_status_text(highlight.status);
      lines.push_back(entry.name + ": sphere " + std::to_string(s + 1) + ": " + reason);
    }
  }
  if (!is_any && !reason.empty())
    throw IoError(entry.photo.string(), reason + "; leave it out, or give its `highlights` by hand");
  return found;
}

Json sphere_report(const SphereLightResult& result, const std::vector<MirrorSphere>& spheres,
                   const Highlights& highlights) {
  Json report;
  for (std::size_t s = 0; s < spheres.size(); ++s) {
    const Vec3& c = result.spheres[s].center;
    report["spheres"].push_back(
        {{"name", spheres[s].name}, {"center", {c.x(), c.y(), c.z()}}, {"rms_px", result.spheres[s].rms_px}});
  }
  for (std::size_t k = 0; k < result.lights.size(); ++k) {
    const SphereLight& light = result.lights[k];
    Json pixels = Json::array();
    for (const auto& pixel : highlights[k]) pixels.push_back(pixel ? Json{pixel->x(), pixel->y()} : Json());
    report["lights"].push_back({{"status", sphere_light_status_text(light.status)},
                                {"spheres", light.num_spheres},
                                {"rms_px", light.rms_px},
                                {"direction_sd_deg", light.direction_sd_deg},
                                {"position_sd_mm", light.position_sd_mm},
                                {"covariance", matrix_json(light.covariance)},
                                {"highlights", pixels}});
  }
  return report;
}

std::string line_of(const SphereLight& light, const std::string& name) {
  const bool is_near = light.light.kind == Light::Kind::Near;
  const Vec3& v = is_near ? light.light.position : light.light.direction;
  std::string text = name + ": " + (is_near ? "at " : "direction ");
  for (int i = 0; i < 3; ++i) text += (i == 0 ? "" : ", ") + short_number_text(rounded(v[i], is_near ? 5 : 4));
  const std::string deg = short_number_text(rounded(light.direction_sd_deg, 2)) + " degrees";
  return text +
         (is_near ? " mm, +- " + short_number_text(rounded(light.position_sd_mm, 2)) + " mm and " + deg
                  : ", +- " + deg) +
         " (" + std::to_string(light.num_spheres) + (light.num_spheres == 1 ? " sphere)" : " spheres)");
}

}  // namespace

CalibrationOutput run_spheres(JsonReader& json, const SphereLightOptions& options, const RunControl& control) {
  const double mm = read_mm_per_unit(json);
  const Response response = json.has("response") ? read_response(json.member("response")) : Response{};
  const JsonReader spheres_json = json.member("spheres");
  const std::size_t num_spheres = spheres_json.elements(kMaxSpheres).size();
  std::vector<LightEntry> entries;
  const JsonReader lights_json = json.member("lights");
  for (const JsonReader& entry : lights_json.elements(kMaxPhotos)) entries.push_back(read_entry(entry, num_spheres));
  if (entries.empty()) lights_json.fail("at least one photograph");
  std::optional<Camera> camera;
  const bool has_camera = json.has("camera");
  if (has_camera) camera = read_camera(json.member("camera"), mm);
  if (!has_camera) {
    if (entries[0].photo.empty()) throw IoError(json.file(), "has no `camera`; without photographs one is needed");
    const ImageInfo info = probe_image(entries[0].photo);
    camera = distant_camera(info.width, info.height);
  }
  const CameraParameters& p = camera->parameters();
  std::vector<MirrorSphere> spheres;
  for (const JsonReader& entry : spheres_json.elements(kMaxSpheres))
    spheres.push_back(read_sphere(entry, mm, p.width, p.height));
  json.finish();
  if (!has_camera && spheres.size() > 1) {
    throw IoError(json.file(),
                  "has several spheres and no `camera`; expected a calibrated camera, or one sphere (then directions "
                  "come out in the camera's frame)");
  }

  CalibrationOutput output;
  Highlights highlights;
  ImageF first;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    control.throw_if_stopped();
    highlights.push_back(entries[k].highlights);
    if (!entries[k].highlights.empty() && !(k == 0 && !entries[k].photo.empty())) continue;
    ImageF photo = read_color(entries[k].photo, response);
    if (photo.width() != p.width || photo.height() != p.height) {
      throw IoError(entries[k].photo.string(), "is " + size_text(photo.width(), photo.height()) + " pixels; expected " +
                                                   size_text(p.width, p.height) + ", as the camera");
    }
    if (entries[k].highlights.empty())
      highlights.back() = find_highlights(entries[k], photo, *camera, spheres, output.lines);
    if (first.empty()) first = std::move(photo);
  }
  const SphereLightResult result = lights_from_spheres(*camera, spheres, highlights, options, control);
  if (!result.has_converged)
    throw CannotComplete("the lights did not converge; check that outlines and highlights belong to the same spheres");
  output.camera = camera;
  output.json = std::make_shared<Json>(result_json(CalibrationKind::Spheres));
  if (has_camera) (*output.json)["camera"] = json_of(*camera);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    if (result.lights[k].status == SphereLightStatus::NoHighlight)
      throw IoError(json.file(), "light " + std::to_string(k + 1) + " has no highlight");
    output.lights.push_back(result.lights[k].light);
    output.lights.back().name = entries[k].name;
    output.lines.push_back(
        line_of(result.lights[k], entries[k].name.empty() ? "light " + std::to_string(k + 1) : entries[k].name));
  }
  if (!has_camera)
    output.lines.push_back(
        "no `camera`: directions are in the camera's frame, for -o lights.lp or a camera that stands at the origin");
  (*output.json)["lights"] = json_of(output.lights);
  (*output.json)["report"] = sphere_report(result, spheres, highlights);
  output.picture = spheres_picture(first, *camera, result.spheres, spheres, highlights);
  return output;
}

}  // namespace patinate::capture
