/// \file
/// Light or color that goes up and down from photograph to photograph, in which one that is exposed differently hides.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "capture/stability/survey.h"

namespace patinate::capture {

/// Names of the channels in files and warnings.
inline constexpr std::array<std::string_view, 3> kChannelNames{"red", "green", "blue"};

/// Unsteadiness of the channel that hides the most.
struct RestlessLight {
  int channel = 0;  ///< 0 = red, 1 = green, 2 = blue.
  double deviation =
      0.0;  ///< Deviation of a photograph's light from the course of the series: relative, one standard deviation.
  double hidden = 1.0;  ///< Factors of light up to this one do not stand out for judge_frames().
};

/// The deviation is estimated from how much gains of neighboring pairs differ: a surface that brightens or darkens
/// steadily makes them equal, while independent factors l of each photograph, with gains l(i) - l(i - 1) in logarithms,
/// make them differ by sqrt(6) times their own deviation. What is hidden are the six deviations of gains from their
/// median that judge_frames() asks for.
/// @param neighbors  As of judge_frames(). @returns Nothing where the deviation is below exposure_threshold, or where a
/// third of a stop, the step of cameras, stands out; nor for fewer than seven pairs, which are judged in another way.
[[nodiscard]] std::optional<RestlessLight> find_restless_light(const std::vector<FramePair>& neighbors,
                                                               const SurveyOptions& options = {});

}  // namespace patinate::capture
