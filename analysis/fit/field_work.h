/// \file
/// What the items of a search for fields share: places that are compared, and the fields as finished items leave them.
#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fit/field_job.h"
#include "analysis/fit/place_field.h"

namespace patinate::analysis {

/// One step of the search. A sweep is one step for each parameter. If there are several parameters, the first sweep
/// searches a single value for each (Flat). Then `options.sweeps` sweeps search fields, with levels over the whole
/// ranges (Whole); for a single parameter, one is enough. The last sweep has levels near the fields found (Near).
struct FieldStep {
  enum class Kind { Flat, Whole, Near };
  Kind kind = Kind::Whole;
  std::size_t parameter = 0;
  int number = 0;  ///< From 0, over all steps.

  [[nodiscard]] std::string solve_name() const { return "field-" + std::to_string(number); }
  [[nodiscard]] std::string level_name(int level) const {
    return "colors-" + std::to_string(number) + "-" + std::to_string(level);
  }
};

/// Any number of items may ask at a time.
class FieldWork {
 public:
  explicit FieldWork(FieldTask given);

  FieldTask task;
  std::vector<FieldStep> steps;

  [[nodiscard]] int num_levels(const FieldStep& step) const;
  /// Where an item's colors, or a step's field, lie.
  [[nodiscard]] static std::filesystem::path colors_file(const FieldStep& step, int level);
  [[nodiscard]] static std::filesystem::path field_file(const FieldStep& step);

  /// The captured surface at the compared places and times. @param frames  Held-out frames exist only with `until`.
  [[nodiscard]] const ColorStack& captured(FitFrames frames, const RunControl& control);
  /// A simulated surface at the same places and times.
  [[nodiscard]] ColorStack simulated(const AgedSurface& surface, FitFrames frames, const RunControl& control);
  /// Root mean square Delta E 1976 over places and times.
  [[nodiscard]] double misfit_by_place(const AgedSurface& surface, FitFrames frames, const RunControl& control);

  /// Fields before a step, in units of the ranges: of every number the last one found, or the starting value
  /// everywhere.
  [[nodiscard]] std::vector<PlaceField> fields_before(const std::filesystem::path& folder, int step) const;
  /// In the numbers' own units, over the atlas.
  [[nodiscard]] std::vector<ImageF> maps_of(const std::vector<PlaceField>& fields) const;
  /// Maps of a step's level.
  [[nodiscard]] std::vector<ImageF> maps_of_level(const std::filesystem::path& folder, const FieldStep& step,
                                                  int level) const;
  /// Colors that a step fits its field to.
  [[nodiscard]] FieldColors colors_of(const std::filesystem::path& folder, const FieldStep& step,
                                      const RunControl& control);

 private:
  [[nodiscard]] PlaceField field_of_level(const std::vector<PlaceField>& before, const FieldStep& step,
                                          int level) const;

  std::mutex mutex_;
  CommonTimes seen_, held_out_;
  std::optional<ColorStack> captured_seen_, captured_held_out_;
};

void save_field(const std::filesystem::path& file, const FittedField& field);
/// @throws IoError
[[nodiscard]] FittedField read_field(const std::filesystem::path& file);

}  // namespace patinate::analysis
