/// \file
/// Numbers of a model that differ from place to place, found as a job: every simulation is an item.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/fit/fit_objective.h"
#include "analysis/fit/fit_parameter.h"
#include "libcommon/job/job_inputs.h"

namespace patinate::analysis {

inline constexpr const char* kFieldReportFile = "report.json";
inline constexpr const char* kFieldPageFile = "report.html";
inline constexpr const char* kFieldFolder = "fields";

/// Whether equal pixels of a history and of the model's atlas show equal places.
enum class FieldPlaces {
  Auto,  ///< Only where both have the charts of one atlas.
  Equal  ///< It is stated.
};
inline constexpr std::array<std::string_view, 2> kFieldPlacesNames{"auto", "equal"};

struct FieldOptions {
  int waves = 6;         ///< Cosines along a side: waves^2 numbers a field at most; [1, 16].
  int levels = 9;        ///< Simulations with one value everywhere, over the range of a number; [3, 65].
  int sweeps = 2;        ///< Times that each of several numbers is looked for, the others as they are; [1, 10].
  int places_size = 16;  ///< Longer side at which places are compared, as means over the surface, px; [8, 512].
  FieldPlaces places = FieldPlaces::Auto;
  int num_times = 17;                ///< Times that are compared, at most; [2, 1024].
  Clock clock = Clock::Absolute;     ///< Equal times, or equal shares of each history's own span.
  std::optional<double> until = {};  ///< Frames of the history after this time are held out, in its unit.
  int size = 128;                    ///< Longer side at which distributions of color are compared, px; 0 = as they are.
};
void describe(OptionVisitor& v, FieldOptions& o);
/// How frames and colors are compared with them.
[[nodiscard]] ObjectiveOptions objective_options(const FieldOptions& options);

/// Ages with values that may differ from place to place. @param values  One map a parameter: of one pixel, the value
/// everywhere, or of the atlas's size. Called by several threads at once.
using AgeWithFields = std::function<AgedSurface(const std::vector<ImageF>& values, const RunControl& control)>;

struct FieldTask {
  std::string model_name;                ///< For the report.
  std::filesystem::path history;         ///< Or a transfer.
  std::vector<FitParameter> parameters;  ///< At least one; between the ends of their ranges values may lie.
  SurfaceOutline outline;                ///< Outline of the model.
  ImageU8 coverage = {};                 ///< 0 / 255: where the atlas shows the model's surface.
  AgeWithFields age;
  /// The model's own file with these maps, beside it in kFieldFolder. @param folder  The output's.
  std::function<void(const std::filesystem::path& folder, const std::vector<ImageF>& values)> write_model;
  FieldOptions options;
  std::function<void(JobInputs& inputs)> add_inputs;  ///< All that the model depends on beside the values.
  std::string command;                                ///< Command that repeats it, for the report; no part of the key.
};

/// The folder has scene.json, what that names in kFieldFolder, report.html, report.json and `after`, a history.
/// @throws InvalidInput if nothing says that places are equal, the history's pixels have another shape than the atlas,
/// a number starts outside its range, or times do not fit (fit_times()); IoError.
[[nodiscard]] JobPlan plan_field(FieldTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
