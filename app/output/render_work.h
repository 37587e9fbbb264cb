/// \file
/// Pictures and movies of a transfer, a simulation, a history or a mesh: what `patinate render` and the Python module
/// do.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "app/device/checked_devices.h"
#include "app/output/aging_mesh.h"
#include "app/output/output_work.h"
#include "app/output/picture_views.h"
#include "app/output/simulated_flakes.h"
#include "app/output/surface_files.h"
#include "app/request/times_choice.h"
#include "patinate/core/options.h"
#include "patinate/output/movie.h"
#include "patinate/output/render.h"
#include "patinate/output/render_surface.h"

namespace patinate::app {

/// A turntable.
struct TurnOptions {
  double turn_deg = 0.0;  ///< Angle that the camera turns around the object from the first picture to the end.
};
void describe(OptionVisitor& v, TurnOptions& o);

enum class ShownMaps { All, Color };

/// Parts of a surface that are shown.
struct ShownOptions {
  ShownMaps maps = ShownMaps::All;
  double film = kWetFilm;
  FlakeOptions flakes;
};
void describe(OptionVisitor& v, ShownOptions& o);

struct RenderTask {
  std::filesystem::path subject;
  std::shared_ptr<const AgingMesh> mesh = {};  ///< In place of a subject, where it is in memory.
  std::filesystem::path output;                ///< Empty: a picture that becomes no file.
  std::filesystem::path environment;
  std::string unit;
  SurfaceFiles files;
  TimesChoice times;
  RenderOptions options;
  bool is_width_given = false, is_height_given = false;  ///< Else a history is shown in its own size.
  MovieOptions movie;
  TurnOptions turn;
  ShownOptions shown;
  SurfaceOptions surface;
  ViewChoice views;
  OutputDevices devices;  ///< Devices of a subject; no picture depends on them.

  [[nodiscard]] bool has_views() const { return !views.views.empty() || views.turntable; }
};

/// Checks a task before anything is opened. @throws UsageError if options do not go together
void check_task(const RenderTask& task);
/// Reads what the work depends on; what is slow happens when the work is run.
/// @throws UsageError if what is asked for does not go together; IoError; InvalidInput
[[nodiscard]] OutputWork render_work(RenderTask task);

}  // namespace patinate::app
