/// \file
/// Pictures over time as a movie or as numbered image files.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/output/output_work.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history.h"
#include "patinate/image/image.h"
#include "patinate/output/movie.h"

namespace patinate::app {

/// Pictures at several times.
struct PictureSeries {
  std::string label;  ///< Label of progress: "export".
  std::string key;    ///< Key of everything that the pictures depend on but the times.
  std::vector<double> times;
  std::function<ImageF(double time, const RunControl& control)> picture;
  /// Where they need not be in memory: the same picture as a file, and as the codes that a movie takes.
  std::function<void(double time, const std::filesystem::path& file, const std::string& key, const RunControl& control)>
      write = {};
  std::function<ImageU8(double time, const RunControl& control)> codes = {};
  std::string measure = "time";  ///< Name that a report gives the numbers in `times`.
};

/// How many pictures a movie has when nobody says.
inline constexpr int kMoviePictures = 100;

/// The name is that of a movie.
[[nodiscard]] bool is_movie(const std::filesystem::path& output);
/// The name is that of a movie, or of numbered images ("aged_%04d.png").
[[nodiscard]] bool is_series(const std::filesystem::path& output);
/// The movie or the images, one picture at a time; each image is up to date or not by itself.
/// @throws UsageError if numbered files are no images; Canceled.
[[nodiscard]] OutputWork series_work(const std::filesystem::path& output, const PictureSeries& series,
                                     const MovieOptions& movie, const RunControl& planning = {});

}  // namespace patinate::app
