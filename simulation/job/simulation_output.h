/// \file
/// The files of a simulation folder, except its history.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "simulation/files/scene_files.h"

namespace patinate::simulation {

/// Part of a simulation folder: the scene as it was simulated.
inline constexpr const char* kSceneFolder = "scene";
/// Keys of the files of the scene that the folder holds, by their paths in it, which tell whether one has changed.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> scene_file_keys(const std::filesystem::path& folder,
                                                                               const SceneCopy& copy);

/// color.png, specular.png, normal.png, height.exr (mm) and model.glb, as `simulation` is composed now.
/// @throws CannotComplete
void write_composed_files(const std::filesystem::path& folder, const std::string& name, Simulation& simulation,
                          const std::string& key, const RunControl& control = {});
/// atlas.exr: channels amount.MATERIAL and original.MATERIAL, float, 1 = kAmountOne quanta; every quantum is told
/// apart. `weight`: the texel's area, SurfaceAtlas::weight(); 0 outside the charts.
void write_atlas_file(const std::filesystem::path& folder, const Simulation& simulation);

/// A parameter map as a control: [0, 1], with what 0 and 1 stand for. Counts end at the 99.5th percentile of the
/// covered texels, so that single texels do not flatten the rest.
struct ParameterControl {
  std::string name;
  ImageF values;  ///< H x W x 1 in [0, 1].
  double low = 0.0;
  double high = 1.0;
  std::string unit;
};
/// @param time_unit  Of the scene.
[[nodiscard]] ParameterControl parameter_control(const Simulation& simulation, const std::string& name,
                                                 TimeUnit time_unit);

/// A control of every object on its own UVs, for transfers onto its mesh: the object's square of the atlas, texel by
/// texel. Of a scene with one object there is nothing to write, nor of an object whose UVs are not its file's. @returns
/// Name of the object and file in `folder`, "controls/OBJECT/NAME.exr"; objects whose names are no file names are
/// called object-0, object-1, ...
std::vector<std::pair<std::string, std::filesystem::path>> write_object_controls(const std::filesystem::path& folder,
                                                                                 const Simulation& simulation,
                                                                                 const ParameterControl& control);

/// Color of the first frame, as composed: half floats tell 8-bit codes apart.
[[nodiscard]] ImageF first_color(const std::filesystem::path& folder);

/// Takes the amounts of a finished folder's atlas.exr over into a simulation of the same scene.
/// @throws IoError if the file is missing or does not fit the scene.
void read_atlas_file(const std::filesystem::path& folder, Simulation& simulation);

/// state.bin: Simulation::snapshot(), from which the simulation continues.
void write_state_file(const std::filesystem::path& folder, const Simulation& simulation);
/// @returns false if there is none. @throws IoError if it does not fit the simulation; nothing is changed then.
[[nodiscard]] bool read_state_file(const std::filesystem::path& folder, Simulation& simulation);

}  // namespace patinate::simulation
