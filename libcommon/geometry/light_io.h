/// \file
/// Lights from our JSON files, from the `.lp` files of reflectance transformation imaging, and from plain tables of
/// directions. Files are not trusted: every count is bounded.
#pragma once

#include <filesystem>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/geometry/camera.h"
#include "patinate/geometry/light.h"

namespace patinate {

/// Meaning of the rows of a text file; the files themselves do not say.
struct LightRows {
  enum class Kind { Directions, Positions };
  enum class Frame {
    Camera,  ///< x right, y up, z from the object to the camera; positions are relative to the camera's center.
    Scanner,
  };
  Kind kind = Kind::Directions;
  Frame frame = Frame::Camera;
};

/// Lights in scanner coordinates, mm, of one of
/// - `.lp`: the number of lights (a 0 may follow it), then a line `NAME x y z` each (names may hold blanks, or be
/// numbers, or be omitted);
/// - `.txt`: the same without names, with or without the count; or three rows, x, y, z, with a column for each light;
/// - `.json`: a calibration of ours, or an array as below.
///
/// Text files give no strengths: is_intensity_known is false. Directions need not be exactly of length 1, but within 5
/// %: positions taken for directions would be wrong without a word.
/// @param mm_per_unit  Of the project that names the file; positions are in its unit (a calibration of ours says its
/// own).
/// @param camera_mm    May be null when no row is in the camera's frame.
/// @throws IoError naming the line: no number, a direction of length 0, another count than the first line says, more
/// than 100,000 lights.
[[nodiscard]] std::vector<Light> read_lights(const std::filesystem::path& path, double mm_per_unit,
                                             const Camera* camera_mm = nullptr, const LightRows& rows = {});

/// Lights as a project has them: an array of {"position" | "direction", "intensity": [r, g, b], "name"} in scanner
/// coordinates; the path of a file as above; or {"file": path, "kind": "directions" | "positions", "frame": "camera" |
/// "scanner"}. `intensity` may be omitted.
/// @throws IoError also for a strength that is not above 0, and for no light at all.
[[nodiscard]] std::vector<Light> read_lights(JsonReader json, double mm_per_unit, const Camera* camera_mm = nullptr);

/// A strength stands for nothing beside lights whose strengths nobody knows.
/// @param json  Where the lights are said. @throws IoError naming the first light without strength if another has one.
void expect_strengths_of_all_or_none(const std::vector<Light>& lights, const JsonReader& json);

/// Puts lights whose names are those of photographs into the photographs' order. Folders, small and capital letters and
/// the extension do not count, where the names are still different without them. Lights that no photograph needs are
/// taken away.
/// @returns whether there are names and none of them is a photograph's: nothing was done
/// @throws IoError if only some of the photographs are named, or one is named twice.
[[nodiscard]] bool are_lights_named_otherwise(std::vector<Light>& lights,
                                              const std::vector<std::filesystem::path>& photos, const JsonReader& json);

/// The array form, in mm; values read back exactly.
[[nodiscard]] Json json_of(const std::vector<Light>& lights);

/// The text of an `.lp` file, CRLF-free, of directional lights, in the camera's frame. @throws InvalidInput if a light
/// is near.
[[nodiscard]] std::string lp_text(const std::vector<Light>& lights, const Camera& camera);

}  // namespace patinate
