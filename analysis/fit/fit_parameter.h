/// \file
/// A number of a model that is to be found: its name, its range, and where in it a value lies.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/core/json.h"

namespace patinate::analysis {

enum class FitScale { Linear, Log };
inline constexpr std::array<std::string_view, 2> kFitScaleNames{"linear", "log"};

/// Range of a parameter, as a user states it.
struct FitRange {
  std::string name;  ///< JSON pointer: "/rules/2/rate".
  double low = 0.0;
  double high = 1.0;                  ///< > low.
  FitScale scale = FitScale::Linear;  ///< Log: low > 0.
  std::string place = {};             ///< "FILE: POINTER" where a file says it, "" from the command line.
  bool is_own = false;                ///< Each capture has a value of its own.
};
/// "/rules/2/rate=0.001:0.1:log". @param option  That gave it, for messages: "--vary". @throws ParseError naming what
/// is wrong.
[[nodiscard]] FitRange parse_fit_range(const std::string& text, const std::string& option = "--vary");
/// {"pointer": "/rules/2/rate", "low": 0.001, "high": 0.1, "scale": "log", "own": true}. @throws IoError
[[nodiscard]] FitRange read_fit_range(JsonReader json);

struct FitParameter {
  FitRange range;
  double start = 0.0;          ///< In the range.
  bool is_whole = false;       ///< Only whole numbers.
  bool is_appearance = false;  ///< Another value needs no new aging, only another appearance of what has aged.
  std::string words = {};      ///< Name that the model gives it, "" where it has none.
  std::string unit = {};       ///< "per h"; "" where it has none.
  std::optional<std::size_t> capture = {};  ///< The capture whose own number it is; nothing: all share it.
};

/// How pages and messages call it: in words where there are any.
[[nodiscard]] const std::string& shown_name(const FitParameter& parameter);

/// Problem of its starting value, "" if there is none.
[[nodiscard]] std::string start_problem(const FitParameter& parameter);
/// The value at a share of the range, with six significant digits (whole if it must be). @param unit  In [0, 1].
[[nodiscard]] double value_at(const FitParameter& parameter, double unit);
/// The inverse, but for rounding; in [0, 1].
[[nodiscard]] double unit_at(const FitParameter& parameter, double value);

}  // namespace patinate::analysis
