#include "capture/project/capture_rig.h"

#include <string>

#include "capture/project/capture_project.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/light_io.h"

namespace patinate::capture {

namespace {

/// [x, y, z] over the plate.
Vec3 read_place(const JsonReader& json, double mm_per_unit) {
  const std::vector<double> v = json.numbers(3, between(-1e9, 1e9));
  const Vec3 place = mm_per_unit * Vec3(v[0], v[1], v[2]);
  if (!(place.z() > 0.0)) json.fail("[x, y, z] of which z, the height over the plate, is above 0");
  return place;
}

std::vector<Vec3> read_cameras(const JsonReader& json, double mm_per_unit, std::size_t num_frames) {
  if (!json.is_array()) json.fail("[x, y, z], or one for each photograph");
  const std::vector<JsonReader> parts = json.elements(std::max<std::size_t>(num_frames, 3) + 1);
  if (parts.empty() || !parts.front().is_array()) return {read_place(json, mm_per_unit)};
  if (parts.size() != num_frames)
    json.fail("one place, or one for each of the " + std::to_string(num_frames) + " photographs");
  std::vector<Vec3> places;
  for (const JsonReader& part : parts) places.push_back(read_place(part, mm_per_unit));
  return places;
}

}  // namespace

std::optional<CaptureRig> read_capture_rig(JsonReader& json, const std::optional<JsonReader>& unit,
                                           const CaptureProject& project) {
  if (json.has("plate") && !json.has("lights")) json.member("plate").fail("`lights` beside it: where the lamp stood");
  if (!json.has("lights")) return std::nullopt;
  const JsonReader lights = json.member("lights");
  if (json.has("plate") == project.scan.has_value())
    lights.fail("a flat `plate` or a `scan` beside it, and not both: where the surface lies");
  if (!unit) lights.fail("a `unit` of its places beside it: um, mm, cm or m");
  const double mm = kMmPerLengthUnit[unit->choice(kLengthUnitNames)];
  CaptureRig rig;
  rig.lights = read_lights(lights, mm, project.scan ? &project.scan->camera_mm : nullptr);
  expect_strengths_of_all_or_none(rig.lights, lights);
  std::vector<std::filesystem::path> photos;
  for (const CapturePhoto& photo : project.frames) photos.push_back(photo.file);
  // With other names lights go in the order of the photographs.
  if (rig.lights.size() != 1) (void)are_lights_named_otherwise(rig.lights, photos, lights);
  if (rig.lights.size() != 1 && rig.lights.size() != project.frames.size()) {
    lights.fail("one light, or one for each of the " + std::to_string(project.frames.size()) +
                " photographs; these are " + std::to_string(rig.lights.size()));
  }
  if (project.scan) return rig;
  for (const Light& light : rig.lights) {
    if (!((light.kind == Light::Kind::Near ? light.position : light.direction).z() > 0.0))
      lights.fail("lights above the plate: their z, its height over the plate, is above 0");
  }
  JsonReader plate = json.member("plate");
  if (!project.texel_size_mm) plate.fail("a `texel_size_mm` beside it: how much of the plate a pixel shows");
  rig.cameras = read_cameras(plate.member("camera"), mm, project.frames.size());
  plate.finish();
  return rig;
}

}  // namespace patinate::capture
