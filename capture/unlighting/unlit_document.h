/// \file
/// unlight.json: what a folder of an unlit step says of itself.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/unlighting/leave_one_out.h"
#include "patinate/capture/unlight.h"
#include "patinate/core/json.h"

namespace patinate::capture {

inline constexpr const char* kUnlitManifestFile = "unlight.json";

struct UnlitMap {
  std::string name;            ///< "albedo", "stddev", "normal", "mask", "specular", "reflectance" or "metalness".
  std::filesystem::path file;  ///< Read: with its folder.
};

struct UnlitLobe {
  std::optional<double> tail;  ///< Exponent of the distribution of slopes; none: no tail.
  double slant = 0.0;
  bool is_about_mirror = false;
  SpecularTint tint = SpecularTint::White;
};

struct UnlitLight {
  std::string name;
  LightReport report;
  LeaveOneOutError leave_one_out;
};

struct UnlitDocument {
  std::string name;
  int width = 0, height = 0, channels = 0;
  std::vector<UnlitMap> maps;
  std::optional<std::vector<SurfaceMaterial>> materials;
  std::int64_t num_surface = 0, num_determined = 0;
  double residual = 0.0, noise_scale = 1.0;
  bool is_absolute = true, is_converged = true;
  Vec3 ambient = Vec3::Zero();
  std::optional<InterreflectionReport> interreflection;
  std::optional<std::string> lobe;
  std::optional<UnlitLobe> lobe_form;
  std::vector<UnlitLight> lights;
  std::vector<std::string> notes;
  std::string key;
};

/// @param path  The folder or its unlight.json. @throws IoError
[[nodiscard]] UnlitDocument read_unlit(const std::filesystem::path& path);
[[nodiscard]] Json unlit_json(const UnlitDocument& document);
/// The JSON Schema of unlight.json.
[[nodiscard]] Json unlit_schema();

}  // namespace patinate::capture
