/// \file
/// factorization.json, and parts of it that items of a factorization hand on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/factorization/factorization_job.h"
#include "analysis/report/report_page.h"

namespace patinate::analysis {

/// How far a frame is from the history's own, over the pixels that both show.
struct FrameError {
  std::int64_t num_pixels = 0;  ///< At least 1.
  double rmse = 0.0;            ///< Linear, of all channels.
  double ciede2000_mean = 0.0;
  double ciede2000_p95 = 0.0;
  bool is_color = true;  ///< Else there are no differences of color.
};

struct FrameRecord {
  double time = 0.0;                    ///< In the history's unit.
  std::optional<double> covered_share;  ///< Of what changes, [0, 1]; given where the frame is extrapolated.
  bool is_held = false;                 ///< What was seen last: the curve foretells nothing better.
  std::optional<FrameError> error;      ///< Nothing where no frame of the history shows a place that is known.
};

void describe(DocumentVisitor& v, FrameRecord& frame);

/// factorization.json.
struct FactorizationManifest {
  std::string name, origin;
  int width = 0, height = 0;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::string clock;
  std::vector<TemporalModel> models;
  Named<std::filesystem::path> maps;
  std::filesystem::path history;  ///< The denoised one.
  std::vector<FrameRecord> frames;
  std::vector<ListedFigure> figures;
  std::vector<ListedCurve> curves;
  ReportOrigin origin_of_report;
  std::optional<FactorQuantity> of;  ///< Not color.

  [[nodiscard]] std::int64_t num_extrapolated() const {
    return std::count_if(frames.begin(), frames.end(),
                         [](const FrameRecord& f) { return f.covered_share.has_value(); });
  }
};
void save_factorization(const std::filesystem::path& folder, FactorizationManifest manifest);
/// @param path  The folder or the file. @returns paths with the folder. @throws IoError if it breaks the format.
[[nodiscard]] FactorizationManifest read_factorization(const std::filesystem::path& path);

void save_models(const std::filesystem::path& file, std::vector<TemporalModel> models);
/// The inverse. @throws IoError
[[nodiscard]] std::vector<TemporalModel> read_models(const std::filesystem::path& file);

}  // namespace patinate::analysis
