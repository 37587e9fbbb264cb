/// \file
/// A factorization as a job: curve, maps, a denoised history, and what they leave over.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/factorization/factor_quantity.h"
#include "libcommon/job/job.h"
#include "patinate/analysis/factorization.h"
#include "patinate/history/history.h"

namespace patinate::analysis {

inline constexpr const char* kFactorizationManifestFile = "factorization.json";
inline constexpr const char* kFactorizationPageFile = "report.html";

struct FactorizationTask {
  std::filesystem::path history;
  FactorQuantity of = FactorQuantity::Color;  ///< A map goes without `times` and with one clock.
  FactorizationOptions options = {};
  std::vector<double> times =
      {};  ///< Of frames that the denoised history gets beside those of the frames, in the history's unit.
  std::string command = {};  ///< What repeats it, for the page; no part of the key.
};

/// Opens the history at once. Of a map, the denoised history has the frames of its source with that map without noise.
/// @throws InvalidInput (fewer than kLeastFrames frames, a map that some frame lacks, a time that is not finite,
/// options), IoError.
[[nodiscard]] JobPlan plan_factorization(FactorizationTask task, const std::filesystem::path& output);

/// What factorization.json says, as far as others need it.
struct FactorizationManifest {
  std::string name;
  int width = 0, height = 0;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::vector<TemporalModel> models;
  int num_frames = 0, num_extrapolated = 0;
  std::vector<std::pair<std::string, std::string>> figures;         ///< Names and values as text, or "undefined: ...".
  std::vector<std::pair<std::string, std::filesystem::path>> maps;  ///< Names and files.
  std::filesystem::path history;                                    ///< The denoised one.
  std::string key;
};
/// @param path  The folder or the file. @throws IoError if it breaks the format.
[[nodiscard]] FactorizationManifest read_factorization(const std::filesystem::path& path);

}  // namespace patinate::analysis
