/// \file
/// What a model of aging gives to be compared: frames of a surface over time, in memory. Fitting knows the model only
/// as these functions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/figures/color_stack.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history.h"

namespace patinate::analysis {

/// A control of a surface, as a history has it.
struct SurfaceControl {
  ControlFacts parameter;
  ImageF values;  ///< H x W x 1 in [0, 1].
};

/// Facts of a model's frames that are known before anything has aged.
struct SurfaceOutline {
  std::string name;
  int width = 0;
  int height = 0;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::vector<double> times;  ///< With the starting values; at least one.
  std::vector<std::string> control_names;
  std::optional<double> texel_size_mm = {};  ///< Decides at which size it is compared, where the history knows its own.
};

/// A surface as it has aged: how it looks over time.
struct AgedSurface {
  std::string name;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::optional<double> texel_size_mm;
  std::vector<double> times;   ///< Strictly increasing.
  std::vector<ImageF> colors;  ///< One a time: H x W x 3, linear.
  ImageU8 mask;                ///< H x W, 0 / 255.
  std::vector<SurfaceControl> controls;
};

/// How something that has aged looks, with other values of the parameters that need no aging.
/// @param values  Of all parameters, in order; those that need aging are as they were.
using ComposeWith = std::function<AgedSurface(const std::vector<double>& values, const RunControl& control)>;
/// Ages from the beginning with these values of all parameters. @param seed_shift  Added to the model's own seed: the
/// same numbers give the same chance. Called by several threads at once. @throws InvalidInput if the model takes no
/// such values together.
using AgeWith =
    std::function<ComposeWith(const std::vector<double>& values, std::uint64_t seed_shift, const RunControl& control)>;

/// Colors at the given times, blended between frames and held at the ends, at a size.
[[nodiscard]] ColorStack stack_of(const AgedSurface& frames, const std::vector<double>& times, int size,
                                  const RunControl& control = {});

/// Writes a history, in an existing folder or a new one.
void write_surface(const std::filesystem::path& folder, const AgedSurface& frames, const std::string& key);

}  // namespace patinate::analysis
