/// \file
/// Models, movies and images of a transfer, a simulation or a history: what `patinate export` and the Python module do.
#pragma once

#include <filesystem>

#include "app/device/checked_devices.h"
#include "app/output/aging_glb.h"
#include "app/output/output_work.h"
#include "app/output/simulated_flakes.h"
#include "app/request/times_choice.h"
#include "patinate/core/options.h"
#include "patinate/output/movie.h"
#include "patinate/output/render.h"

namespace patinate::app {

struct SequenceFormat {
  enum class Kind { Png, Exr, Tif } kind = Kind::Png;
};
void describe(OptionVisitor& v, SequenceFormat& o);

/// How a model stands.
struct ModelAxis {
  UpAxis up = UpAxis::Y;  ///< Up axis of the mesh; models have theirs along +Y.
};
void describe(OptionVisitor& v, ModelAxis& o);

struct ExportTask {
  std::filesystem::path subject;
  std::filesystem::path output;  ///< Its name says what is made: a model, a movie, numbered images, or a folder.
  TimesChoice times;
  SequenceFormat format;
  MovieOptions movie;
  ModelAxis axis;
  FlakeOptions flakes;    ///< Of models.
  OutputDevices devices;  ///< No output depends on them.
};

/// Checks an output before anything is opened. @throws UsageError
void check_output(const ExportTask& task);
/// Reads what the work depends on; what is slow happens when the work is run.
/// @param planning  Asked to stop while thousands of times are planned.
/// @throws UsageError if what is asked for does not go together; IoError; InvalidInput; Canceled
[[nodiscard]] OutputWork export_work(const ExportTask& task, const RunControl& planning = {});

}  // namespace patinate::app
