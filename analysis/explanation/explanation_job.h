/// \file
/// Which parameter explains a reference, as a job: one item a control map, then `explanation.json`, `figures.csv` and
/// `report.html`.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "analysis/explanation/explanation.h"
#include "libcommon/job/job.h"
#include "patinate/controls/control_map.h"

namespace patinate::analysis {

inline constexpr const char* kExplanationFile = "explanation.json";
inline constexpr const char* kExplanationPageFile = "report.html";
inline constexpr const char* kExplanationTableFile = "figures.csv";

/// Reference that is to be explained, on the atlas of the mesh.
struct SurfaceReference {
  ImageF values;        ///< H x W x 1, finite: how aged each texel is; any unit, the high end is the aged one.
  ImageU8 mask;         ///< 0 = not known; empty = known everywhere.
  ImageF color;         ///< H x W x 3, linear, to be shown; may be empty.
  std::string name{};   ///< \"aged.jpg\"
  std::string about{};  ///< "luminance of aged.jpg; its low end counts as aged"
  std::string key{};    ///< Content key of all this.
  std::vector<std::string> notes = {};  ///< Notes for the user, whole sentences without a full stop.
};

/// A control map that may explain it.
struct ExplainingControl {
  std::string name;  ///< Name as an expression says it.
  std::string key;   ///< Content key of its map.
  std::function<ControlMap(const RunControl&)> make;
  std::vector<std::string> options = {};  ///< Options that any command needs beside the name: " --up 0,0,1".
  bool may_fail = false;                  ///< InvalidInput then makes it a skipped one with a reason, and not the end.
};

struct ExplanationTask {
  std::shared_ptr<const TexelMap> map;  ///< In mm.
  std::string mesh_name;
  std::string mesh_key;  ///< Content key of the mesh with its UVs.
  SurfaceReference reference;
  std::vector<ExplainingControl> controls;
  ExplanationOptions options;
  std::uint64_t seed = 0;
  bool is_z_up = false;  ///< For pictures.
  std::string command;   ///< Command that repeats it, for the report; no part of the key.
};

/// @throws InvalidInput if an option is out of range, there is no control, two share a name, the reference has not the
/// atlas' size, is the same everywhere, or too little of the surface is inside its mask.
[[nodiscard]] JobPlan plan_explanation(ExplanationTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
