/// \file
/// What the items of a factorization share. Files are read when the first of them needs them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "analysis/factorization/factor_image.h"
#include "analysis/factorization/factorization_job.h"
#include "analysis/factorization/forecast.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// A frame of the denoised history.
struct FactoredFrame {
  double time = 0.0;
  int source = -1;  ///< Frame of the history; -1: none has this time.
  bool is_extrapolated = false;
};

struct FactorizationWork {
  explicit FactorizationWork(FactorizationTask asked);

  FactorizationTask task;
  HistoryReader history;
  std::optional<QuantityHistory> map;  ///< Quantity that is factorized where it is not the color.
  ImageU8 mask;
  std::vector<FactoredFrame> frames;  ///< By time.
  std::string key;                    ///< Key of the whole plan.

  [[nodiscard]] bool is_color() const { return task.of == FactorQuantity::Color; }
  /// The history whose colors are taken apart.
  [[nodiscard]] const History& values() const {
    return map ? static_cast<const History&>(*map) : static_cast<const History&>(history);
  }
  [[nodiscard]] std::size_t num_models() const { return task.options.clock == FactorClock::Shared ? 1 : 3; }
  [[nodiscard]] int width() const { return history.manifest().width; }
  [[nodiscard]] int height() const { return history.manifest().height; }
  /// Rows that a band of the maps holds: as many as fit into memory with all their times.
  [[nodiscard]] int rows_per_band() const;
  [[nodiscard]] int num_bands() const { return (height() + rows_per_band() - 1) / rows_per_band(); }

  /// The curves and factors as the stage before has left them.
  struct Factored {
    std::vector<TemporalModel> models;
    ImageF image;
  };
  [[nodiscard]] const Factored& factored(const std::filesystem::path& folder);
  /// Whether frames beyond the last one are asked for.
  [[nodiscard]] bool looks_ahead() const {
    return !frames.empty() && frames.back().is_extrapolated &&
           frames.back().time > history.manifest().frames.back().time;
  }

 private:
  std::mutex mutex_;
  std::optional<Factored> factored_;
};

/// Files that later items read.
[[nodiscard]] std::filesystem::path work_file(const std::string& name);

/// Writes the curve: .job/work/curve.json.
void make_curve(FactorizationWork& work, const std::filesystem::path& folder, const RunControl& control);
/// Writes how well a curve that had not seen the last frames foretells them: .job/work/forecast.json.
void make_forecast_file(FactorizationWork& work, const std::filesystem::path& folder, const RunControl& control);
/// Reads the forecast that it wrote; nothing where none was asked for.
[[nodiscard]] std::optional<Forecast> read_forecast(const FactorizationWork& work, const std::filesystem::path& folder);
/// Writes a band of factors: .job/work/rows.K.exr.
void make_rows(FactorizationWork& work, int band, const std::filesystem::path& folder, const RunControl& control);
/// Brings bands together and to their gauge; writes the maps, the controls, masks and maps of the history, and what
/// later items read.
void make_maps(FactorizationWork& work, const std::filesystem::path& folder);
/// The files that make_maps() writes always, and the one that it writes where a rate is known at all.
[[nodiscard]] std::vector<std::filesystem::path> map_outputs(const FactorizationWork& work);
[[nodiscard]] std::filesystem::path rate_control_file(const FactorizationWork& work);
/// Writes a frame of the history and .job/work/frame.K.json: how far it is from the frame that it stands for.
void make_frame(FactorizationWork& work, int index, const std::filesystem::path& folder, const RunControl& control);

/// Files that a frame of the denoised history has beside its color: its mask, and maps; relative to the history.
[[nodiscard]] std::vector<std::filesystem::path> files_beside(const FactorizationWork& work, int index);

/// Names and files of the maps, relative to the output.
[[nodiscard]] std::vector<std::pair<std::string, std::filesystem::path>> factor_maps();
/// The name that the rate has as a control.
[[nodiscard]] std::string rate_control_name(const HistoryManifest& history);

/// Writes history.json, factorization.json, the page and the curves as CSV.
void write_factorization(FactorizationWork& work, const std::filesystem::path& folder, const RunControl& control);

}  // namespace patinate::analysis
