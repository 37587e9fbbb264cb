/// \file
/// How far a simulated surface is from a captured one, as one number: a weighted mean of figures of a comparison.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/figures/compared_pair.h"
#include "analysis/fit/aged_surface.h"

namespace patinate::analysis {

/// Figures that can be fitted; docs/algorithms/fit.md says what each is. All are >= 0, 0 for equal surfaces, and of
/// like size: Delta E 1976, CIEDE2000, L* (contrast), or per cent of the places (covered, rusted) or of the compared
/// span of time (onset, saturation).
enum class FitFigure {
  ColorDistribution,
  MeanColor,
  Covered,
  Onset,
  Saturation,
  ColorByControl,
  RateByControl,
  Ciede2000,
  Contrast,
  Rusted
};
inline constexpr std::array<std::string_view, 10> kFitFigureNames{
    "color_distribution", "mean_color",      "covered",   "onset",    "saturation",
    "color_by_control",   "rate_by_control", "ciede2000", "contrast", "rusted"};
inline constexpr std::array<std::string_view, 10> kFitFigureUnits{
    "Delta E 1976", "Delta E 1976", "% of places", "% of the span", "% of the span", "Delta E 1976",
    "Delta E 1976", "Delta E 2000", "L*",          "% of places"};

struct FitTerm {
  FitFigure figure = FitFigure::ColorDistribution;
  double weight = 1.0;  ///< > 0.
};
/// "color_distribution", "covered=0.5". @throws ParseError with a did-you-mean.
[[nodiscard]] FitTerm parse_fit_term(const std::string& text);

struct ObjectiveOptions {
  int size = 128;                 ///< Longer side at which the surfaces are compared, px; 0 = as they are.
  int num_times = 17;             ///< Times at which they are compared, at most; [2, 1024].
  Clock clock = Clock::Absolute;  ///< Equal times, or equal shares of each history's own span.
  /// Frames of the history after this time are held out, in its unit: what a fit is then asked for. Empty: none.
  std::optional<double> until = {};
  double visible_delta_e = 5.0;  ///< A change from here on is seen; Delta E 1976, > 0.
  int num_classes = 5;           ///< Number of classes of a control; [1, 50].
  /// Places of a time whose colors color_distribution compares, at most, always the same; [0, 65536], 0 = all.
  int samples = 0;
};
void describe(OptionVisitor& v, ObjectiveOptions& o);
/// Options for a comparison.
[[nodiscard]] CompareOptions compare_options(const ObjectiveOptions& options);

/// Frames of the history that are compared, where ObjectiveOptions::until divides them.
enum class FitFrames { Seen, HeldOut };

/// Times at which a history and a model are compared, those up to `until` or those after it.
/// @param name  The history's, for errors. @throws InvalidInput if they have no time in common, fewer than two lie up
/// to `until`, or none after it.
[[nodiscard]] CommonTimes fit_times(const HistoryFacts& captured, const SurfaceOutline& outline,
                                    const ObjectiveOptions& options, FitFrames frames, const std::string& name);

struct ObjectiveValue {
  std::optional<double>
      objective;  ///< Sum of weight x figure over the sum of the weights; nothing when a figure is undefined.
  std::vector<std::optional<double>> figures;  ///< One a term.
  std::string problem;                         ///< Why there is no value; "" when there is.
};

/// Compares simulated surfaces with one captured history, which is prepared once. Both are brought to one size as a
/// comparison does. Thread-safe.
class FitObjective {
 public:
  /// @param outline  Of what will be compared: times, size and names of controls decide what can be. The compared times
  /// are fixed by it; later surfaces that end earlier are held at their ends.
  /// @throws InvalidInput if the history has a single frame, no time in common with the outline, no change where a
  /// figure is about change, no control in common where one is about controls, or other pixels where one goes place by
  /// place; with `until`, if fewer than two times lie up to it or none after it, or a figure is about the whole course;
  /// IoError.
  FitObjective(TextureSeries captured, const SurfaceOutline& outline, std::vector<FitTerm> terms,
               const ObjectiveOptions& options, FitFrames frames = FitFrames::Seen, const RunControl& control = {});
  ~FitObjective();
  FitObjective(FitObjective&&) noexcept;

  [[nodiscard]] const std::vector<FitTerm>& terms() const;
  [[nodiscard]] std::size_t num_times() const;
  [[nodiscard]] ObjectiveValue operator()(const AgedSurface& frames, const RunControl& control = {}) const;

  /// Objective with a simulated surface in the place of the captured one, off by one draw of the deviations that the
  /// capture states: all places together, since neighbors may be off together. @param draw  Number of the draw.
  [[nodiscard]] FitObjective with_captured(const AgedSurface& frames, std::uint64_t draw,
                                           const RunControl& control = {}) const;

 private:
  struct State;
  explicit FitObjective(std::unique_ptr<const State> state);
  std::unique_ptr<const State> state_;
};

}  // namespace patinate::analysis
