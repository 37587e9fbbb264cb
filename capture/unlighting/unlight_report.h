/// \file
/// Pictures and a page of what an unlighting did.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "capture/unlighting/leave_one_out.h"

namespace patinate::capture {

/// Where samples_picture() of a lamp goes: "samples/01.png" for 0.
[[nodiscard]] std::string samples_file(std::size_t light);
/// Names of the states of samples, by SampleState: "clean", "cast_shadow", ...
[[nodiscard]] std::string sample_state_name(SampleState state);

/// The color that stands for a state in every picture, linear: blue = cast shadow, cyan = darker, red = brighter,
/// magenta = not valid, black = unlit, light gray = clean, dark gray = outside.
[[nodiscard]] std::array<float, 3> sample_state_color(SampleState state);

/// Picture of one lamp's samples, as sample_state_color() over the photograph, which shows where they are clean.
/// @returns H x W x 3, linear.
[[nodiscard]] ImageF samples_picture(const UnlightInput& input, const UnlightResult& result, int light);
/// Normals as colors in the camera's axes: red right, green up, blue to the camera. Codes, H x W x 3.
[[nodiscard]] ImageU8 normal_picture(const UnlightResult& result, const Eigen::Matrix3d& camera_from_world);
/// Linear, H x W x 3; gray is repeated. Values above 1 are brought below it together. `factor` is what they were
/// multiplied by.
[[nodiscard]] ImageF color_picture(const ImageF& map, double& factor);

/// Writes albedo.png, normal.png, stddev.png, specular.png (where fitted), samples/NN.png and report.html into
/// `folder`.
/// @param name  Of the step, for the title.
void write_unlight_report(const std::filesystem::path& folder, const std::string& name, const UnlightInput& input,
                          const UnlightResult& result, const std::vector<LeaveOneOutError>& predicted,
                          const Eigen::Matrix3d& camera_from_world);

}  // namespace patinate::capture
