/// \file
/// What makes an output - a file, several, or a folder - as a value: a command runs it with its notes, plans and dry
/// runs, the Python module runs it plainly.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/job/job.h"
#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/output/movie.h"

namespace patinate::app {

/// One of several outputs, each made, and up to date, by itself: the picture of a time.
struct OutputPiece {
  std::vector<std::filesystem::path> files;  ///< Files of its tiles, and what is written beside them.
  std::string key;
  std::function<void(const RunControl& control)> make = {};  ///< Empty where the caller makes it.
};
/// With the keys that lie there.
[[nodiscard]] std::vector<OutputFile> output_files(const std::vector<std::filesystem::path>& files);

/// Frames of a movie, picture by picture.
struct MovieFrames {
  std::filesystem::path output;
  std::string label;                                                   ///< Label of progress.
  std::string key;                                                     ///< Key of the movie.
  std::vector<std::string> keys;                                       ///< Keys of each picture.
  std::function<ImageU8(int index, const RunControl& control)> codes;  ///< sRGB codes.
  MovieOptions options;
};

/// Either one file (`make`), several (`pieces`) or a folder (`plan`).
struct OutputWork {
  std::filesystem::path output;         ///< Output as it was asked for.
  std::string label;                    ///< Label of progress: "export".
  std::string key;                      ///< Key of all that the output depends on.
  std::string existing_key;             ///< Key of what is there; of a single file alone.
  std::vector<OutputFile> beside = {};  ///< Files that `make` writes beside it.
  std::function<void(const RunControl& control)> make = {};
  /// Makes the picture where it is one image, which need not become a file.
  std::function<ImageF(const RunControl& control)> picture = {};
  std::vector<OutputPiece> pieces = {};
  std::shared_ptr<const MovieFrames> movie = {};  ///< Frames of a movie: what a plan cuts `make` into.
  std::optional<JobPlan> plan = {};
  std::vector<std::string> notes = {};  ///< Lines for a person.
  std::shared_ptr<const Json> report;   ///< Content of a report beside output and status: an object.
};

/// The output and what is written beside it, where that is no folder and no several.
[[nodiscard]] std::vector<OutputFile> files_of(const OutputWork& work);
/// Makes what is not up to date. @throws CannotComplete if something else lies there, unless `force`; what the work
/// throws.
JobStatus make_output(const OutputWork& work, bool force, const RunControl& control);
/// Makes these of its pieces, one after another.
void make_pieces(const OutputWork& work, const std::vector<std::size_t>& todo, const RunControl& control);

}  // namespace patinate::app
