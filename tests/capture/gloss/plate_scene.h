/// \file
/// The synthetic glossy plate through the whole of ingest, and how far what comes out is off its truth.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets_synthetic/plate.h"
#include "patinate/core/json.h"

namespace patinate::testing_support {

/// Errors of one photograph's frame. Medians over pixels that are polish (less than a twentieth patina).
struct PlateErrors {
  double roughness = 0.0;    ///< Found less truth.
  double f0 = 0.0;           ///< Found over truth, less 1; of the mean over channels.
  double albedo = 0.0;       ///< Mean of |found - truth| over the mean of truth, all pixels and channels.
  double lambert = 0.0;      ///< Error where the whole photograph is taken for matte.
  double albedo_near = 0.0;  ///< Error of the tenth of the pixels nearest to the mirror's direction.
  double lambert_near = 0.0;
};

struct PlateRun {
  std::vector<PlateErrors> errors = {};  ///< One a photograph; roughness and f0 are 0 where no gloss was written.
  Json gloss = {};                       ///< gloss.json.
  Json history = {};                     ///< history.json.
};
/// @param change  What to alter in capture.json before it is ingested. @param folder  Empty.
[[nodiscard]] PlateRun ingested_plate(const datasets::PlateOptions& options, const std::filesystem::path& folder,
                                      const std::function<void(Json&)>& change = {});

/// A line for people. @param name  Of the case.
void print_errors(const std::string& name, const PlateRun& run);

}  // namespace patinate::testing_support
