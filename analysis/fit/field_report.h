/// \file
/// What a search for fields found, for people and for programs.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fit/field_job.h"
#include "analysis/fit/place_field.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

/// How far a surface is, at frames seen or held out.
struct FieldMisfit {
  double by_place = 0.0;                          ///< Root mean square Delta E 1976 over places and times.
  std::optional<double> color_distribution = {};  ///< Delta E 1976, as a fit's objective.
};

/// Misfits on seen and held-out frames.
struct FieldMisfits {
  FieldMisfit seen;
  std::optional<FieldMisfit> held_out = {};
};

/// Share of what `without` leaves that `with` does not. @returns nothing where nothing is left.
[[nodiscard]] std::optional<double> explained_share(double with, double without);

/// A number that became a field.
struct FoundField {
  FittedField fitted;                   ///< In units of its range.
  double single = 0.0;                  ///< The best number for all places, in its own unit.
  double low = 0.0, high = 0.0;         ///< Least and largest value on the surface.
  std::optional<FieldMisfits> without;  ///< With that number for all places, the others as found; of several fields.
};

struct FieldOutcome {
  std::size_t num_times_seen = 0, num_times_held_out = 0;
  int num_simulations = 0;
  std::string time_unit = {};
  FieldMisfits before;                    ///< With the model's own numbers.
  FieldMisfits single;                    ///< With the best numbers for all places.
  FieldMisfits after;                     ///< With the fields.
  std::optional<double> last_frame = {};  ///< color_distribution of the last frame seen, held, at frames held out.
  std::vector<FoundField> fields;         ///< One a parameter.
  std::vector<Picture> maps;              ///< Maps of the fields, with a `source`.
  std::vector<Picture> pictures;          ///< Pictures of frames, with a `source`.
};

/// Writes report.html and report.json. @throws CannotComplete
void write_field_report(const std::filesystem::path& folder, const FieldTask& task, const FieldOutcome& outcome,
                        const std::string& key);

}  // namespace patinate::analysis
