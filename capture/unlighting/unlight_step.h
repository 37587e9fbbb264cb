/// \file
/// One step of a relit capture on its own: what `patinate unlight` reads.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "patinate/capture/unlight.h"
#include "patinate/geometry/camera.h"
#include "patinate/image/color.h"

namespace patinate::capture {

/// A step file (`patinate.unlight`, docs/unlighting.md). Every path is usable as it stands.
struct UnlightStep {
  std::filesystem::path file;
  std::string name = {};
  double mm_per_unit = 1.0;
  Response response = {};
  std::optional<Camera> camera_mm = {};  ///< Always there with a scan.
  std::vector<Light> lights = {};        ///< mm.
  std::vector<std::filesystem::path> photos = {};
  std::optional<std::filesystem::path> ambient = {};
  std::optional<std::filesystem::path> scan = {};
  std::optional<std::filesystem::path> mask = {};
  std::vector<std::string> notes = {};  ///< Assumptions, one line each.
  int width = 0;                        ///< Width of every photograph.
  int height = 0;
  bool is_gray = false;    ///< Every photograph has one channel.
  bool has_codes = false;  ///< Every photograph is of integers, which the response decodes.

  [[nodiscard]] bool are_strengths_known() const;
};

/// Reads and checks a step: every file is there and an image of the right size; pixels are not decoded.
/// @throws IoError / InvalidInput naming the file and what is wrong.
[[nodiscard]] UnlightStep read_unlight_step(const std::filesystem::path& file);

/// Input of unlight().
struct UnlightScene {
  UnlightInput input;
  std::unique_ptr<const Mesh> scan;  ///< That input.blockers points to; null without a scan.
  ImageF ambient;                    ///< Ambient light that was subtracted; empty when none was.
};

/// Decodes the photographs (code 254 of 255 and more is saturated), subtracts the ambient one, and casts every pixel on
/// the scan. Without a scan the frame is the camera's, or, when none is given either, x right, y up, z to the camera.
/// @throws IoError also if the camera does not see the scan.
[[nodiscard]] UnlightScene load_unlight_scene(const UnlightStep& step, const RunControl& control = {});

}  // namespace patinate::capture
