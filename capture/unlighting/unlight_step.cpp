#include "capture/unlighting/unlight_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/project/capture_project.h"
#include "capture/project/scan_control.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/light_io.h"
#include "libcommon/geometry/mesh_repair.h"
#include "libcommon/geometry/scan_mesh.h"
#include "libcommon/image/response_io.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxPhotos = 1000;
constexpr float kSaturatedCode = 253.5f / 255.0f;  ///< Codes from 254 on count as saturated.

/// x right, y up, z to the camera: what photometric stereo is written in.
Camera camera_of_photographs(int width, int height) {
  CameraParameters p;
  p.width = width, p.height = height;
  p.fx = p.fy = std::max(width, height);
  p.cx = 0.5 * (width - 1), p.cy = 0.5 * (height - 1);
  p.rotation = Vec3(1, -1, -1).asDiagonal();
  return Camera(p);
}

std::vector<fs::path> read_photos(JsonReader json) {
  std::vector<fs::path> photos;
  if (json.is_object()) {
    const JsonReader at = json.member("pattern");
    const fs::path pattern = at.path();
    json.finish();
    photos = list_files(pattern.parent_path(), pattern.filename().string());
    if (photos.empty()) at.fail("a pattern that some files match");
    return photos;
  }
  if (!json.is_array()) json.fail("a list of files, one for each light, or {\"pattern\": \"photos/*.png\"}");
  for (const JsonReader& photo : json.elements(kMaxPhotos)) photos.push_back(photo.path());
  if (photos.empty()) json.fail("one photograph for each light");
  return photos;
}

void check_photo_size(const fs::path& file, const ImageInfo& info, const UnlightStep& step) {
  if (info.width == step.width && info.height == step.height) return;
  throw IoError(file.string(), "is " + size_text(info.width, info.height) + " pixels; expected " +
                                   size_text(step.width, step.height) + ", as the first photograph");
}

void probe_photos(UnlightStep& step) {
  step.is_gray = step.has_codes = true;
  for (const fs::path& photo : step.photos) {
    const ImageInfo info = probe_image(photo);
    if (step.width == 0) step.width = info.width, step.height = info.height;
    check_photo_size(photo, info, step);
    step.is_gray = step.is_gray && info.channels.size() <= 2 && !info.is_raw;
    step.has_codes = step.has_codes && info.is_integer && !info.is_raw;
  }
  for (const auto& file : {step.ambient, step.mask}) {
    if (file) check_photo_size(*file, probe_image(*file), step);
  }
}

ImageF first_channel(const ImageF& in) {
  ImageF out(in.width(), in.height());
  for (std::int64_t i = 0; i < in.num_pixels(); ++i) out.data()[i] = in.data()[i * in.channels()];
  return out;
}

Mesh read_scan(const UnlightStep& step) {
  const std::string extension = lower_extension(*step.scan);
  try {
    Mesh mesh = extension == ".gltf" || extension == ".glb" || extension == ".obj"
                    ? read_mesh(*step.scan)
                    : mesh_of_scan(read_point_cloud(*step.scan));
    mesh = repair_mesh(std::move(mesh)).mesh;
    scale_mesh(mesh, step.mm_per_unit);
    return mesh;
  } catch (const InvalidInput& e) {
    throw IoError(step.scan->string(), e.what());
  }
}

/// Photographs, which of their samples are not saturated, and what was subtracted.
void develop_photos(const UnlightStep& step, UnlightScene& scene, const RunControl& control) {
  const auto read = [&](const fs::path& file) {
    const ImageF color = read_color(file, step.response);
    return step.is_gray ? first_channel(color) : color;
  };
  if (step.ambient) scene.ambient = read(*step.ambient);
  const std::size_t n = step.photos.size();
  scene.input.photos.resize(n);
  scene.input.valid.resize(n);
  parallel_for(static_cast<std::int64_t>(n), 1, control, [&](std::int64_t begin, std::int64_t) {
    const auto k = static_cast<std::size_t>(begin);
    const ImageInfo info = probe_image(step.photos[k]);
    const float white = info.is_raw ? kSaturatedCode : step.response.linear_from_code(kSaturatedCode);
    ImageF photo = read(step.photos[k]);
    ImageU8 valid(photo.width(), photo.height(), 1, 255);
    for (std::int64_t i = 0; i < photo.num_pixels(); ++i) {
      for (int c = 0; c < photo.channels(); ++c) {
        float& v = photo.data()[i * photo.channels() + c];
        if ((info.is_integer || info.is_raw) && v >= white) valid.data()[i] = 0;
        if (!scene.ambient.empty()) v -= scene.ambient.data()[i * photo.channels() + c];
      }
    }
    scene.input.photos[k] = std::move(photo);
    scene.input.valid[k] = std::move(valid);
  });
}

void cast_on_scan(const UnlightStep& step, UnlightScene& scene, const RunControl& control) {
  scene.scan = std::make_unique<const Mesh>(read_scan(step));
  const PhotoPart whole{.width = static_cast<double>(step.width),
                        .height = static_cast<double>(step.height),
                        .num_columns = step.width,
                        .num_rows = step.height};
  ScanMaps maps = scan_maps(*scene.scan, *step.camera_mm, whole, {}, control);
  if (maps.num_seen == 0)
    throw IoError(step.scan->string(), "the camera does not see the scan; check `unit` and the camera's pose");
  UnlightInput& in = scene.input;
  if (in.mask.empty()) in.mask = ImageU8(step.width, step.height, 1, 255);
  for (std::int64_t i = 0; i < in.mask.num_pixels(); ++i)
    in.mask.data()[i] = in.mask.data()[i] != 0 && maps.seen.data()[i] != 0 ? 255 : 0;
  in.position_mm = std::move(maps.position_mm);
  in.normal = std::move(maps.normal);
  in.camera_center = step.camera_mm->center();
  in.blockers = scene.scan.get();
}

}  // namespace

bool UnlightStep::are_strengths_known() const {
  return std::all_of(lights.begin(), lights.end(), [](const Light& light) { return light.is_intensity_known; });
}

UnlightStep read_unlight_step(const fs::path& file) {
  const Json content = load_json(file);
  JsonReader json(file.string(), content);
  json.expect_format("patinate.unlight", 1);
  UnlightStep step{.file = file};
  if (json.has("name")) step.name = json.member("name").string();
  if (json.has("response")) step.response = read_response(json.member("response"));
  step.photos = read_photos(json.member("photos"));
  if (json.has("ambient")) step.ambient = json.member("ambient").path();
  if (json.has("mask")) step.mask = json.member("mask").path();
  if (json.has("scan")) step.scan = json.member("scan").path();
  probe_photos(step);
  if (json.has("unit"))
    step.mm_per_unit = kMmPerLengthUnit[json.member("unit").choice(kLengthUnitNames)];
  else if (step.scan)
    json.fail("the length unit of scan, camera and lights: \"unit\": um, mm, cm or m");
  if (json.has("camera")) {
    const JsonReader at = json.member("camera");
    step.camera_mm = read_camera(at, step.mm_per_unit);
    const CameraParameters& p = step.camera_mm->parameters();
    if (p.width != step.width || p.height != step.height) {
      at.fail("a camera of the photographs, " + size_text(step.width, step.height) + " pixels; this one takes " +
              size_text(p.width, p.height));
    }
  } else if (step.scan) {
    json.fail("a \"camera\", which says where the photographs see the scan");
  }
  std::error_code error;
  if (step.scan && !fs::exists(*step.scan, error)) throw IoError(step.scan->string(), "is not there; `scan` names it");
  const Camera frame = step.camera_mm ? *step.camera_mm : camera_of_photographs(step.width, step.height);
  const JsonReader lights = json.member("lights");
  step.lights = read_lights(lights, step.mm_per_unit, &frame);
  expect_strengths_of_all_or_none(step.lights, lights);
  const bool is_otherwise = are_lights_named_otherwise(step.lights, step.photos, lights);
  const bool is_own = lights.is_array() || (lights.is_string() && lights.path().extension() == ".json");
  if (is_otherwise && !is_own) {  // Names that a person gives in a project are no file names.
    step.notes.push_back("the lights have other names than the photographs, and go by their order: " +
                         step.lights.front().name + " with " + step.photos.front().filename().string());
  }
  if (step.lights.size() != step.photos.size()) {
    lights.fail("one light for each of the " + std::to_string(step.photos.size()) + " photographs; these are " +
                std::to_string(step.lights.size()));
  }
  const bool is_any_near =
      std::any_of(step.lights.begin(), step.lights.end(), [](const Light& l) { return l.kind == Light::Kind::Near; });
  if (is_any_near && !step.scan) json.fail("a \"scan\", without which near lights cannot be used");
  json.finish();
  return step;
}

UnlightScene load_unlight_scene(const UnlightStep& step, const RunControl& control) {
  UnlightScene scene;
  scene.input.lights = step.lights;
  develop_photos(step, scene, control.part(0.0, 0.4));
  if (step.mask) scene.input.mask = read_mask(*step.mask);
  if (step.scan) cast_on_scan(step, scene, control.part(0.4, 1.0));
  if (!step.scan && step.camera_mm)
    scene.input.view_direction = -(step.camera_mm->parameters().rotation.transpose() * Vec3(0, 0, 1));
  control.report(1.0);
  return scene;
}

}  // namespace patinate::capture
