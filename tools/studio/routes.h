/// \file
/// The answers, one function each. For studio.cpp.
#pragma once

#include <filesystem>
#include <functional>

#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "tools/studio/http.h"
#include "tools/studio/jobs.h"
#include "tools/studio/live_scene.h"
#include "tools/studio/painted_transfer.h"
#include "tools/studio/place.h"
#include "tools/studio/served_folder.h"
#include "tools/studio/surface_in_time.h"

namespace patinate::studio {

/// Answered with 404.
class NotFound : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

/// Answered with 409: what the request is about is not as it was.
class Conflict : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

/// One request and what an answer may need.
struct Asked {
  const ServedFolder& folder;
  OpenedPlaces& opened;
  LiveScenes& live;
  PaintedTransfers& painted;
  Jobs& jobs;
  const RequestTarget& target;
  RunControl control;

  /// The place that the request names, and what it is. @throws NotFound
  [[nodiscard]] std::pair<std::filesystem::path, PlaceKind> place() const;
  /// That place, opened. @throws NotFound; InvalidInput if it has no color over time.
  [[nodiscard]] std::shared_ptr<const SurfaceInTime> surface() const;
  /// A file that the request names by `path`, below its place. @throws NotFound
  [[nodiscard]] std::filesystem::path file() const;
  /// @throws InvalidInput if it is missing, no number, or outside [low, high].
  [[nodiscard]] double number(const std::string& name, double low, double high) const;
  [[nodiscard]] int integer(const std::string& name, int low, int high) const;
};

[[nodiscard]] HttpResponse json_response(const Json& json, int status = 200);

[[nodiscard]] HttpResponse answer_places(const Asked& asked, const std::string& version);
[[nodiscard]] HttpResponse answer_place(const Asked& asked);
[[nodiscard]] HttpResponse answer_texture(const Asked& asked);
[[nodiscard]] HttpResponse answer_map(const Asked& asked);
[[nodiscard]] HttpResponse answer_curve(const Asked& asked);
[[nodiscard]] HttpResponse answer_mesh(const Asked& asked);
/// Where small plants can grow on a scene.
[[nodiscard]] HttpResponse answer_plants(const Asked& asked);
[[nodiscard]] HttpResponse answer_preview(const Asked& asked);
[[nodiscard]] HttpResponse answer_file(const Asked& asked);
[[nodiscard]] HttpResponse answer_live(const Asked& asked);
/// The photographs of a capture and the points that are marked in them.
[[nodiscard]] HttpResponse answer_landmarks(const Asked& asked);
/// Saves such points to the project and its table. @throws Conflict if the project was changed since it was read;
/// InvalidInput, IoError, CannotComplete, and nothing was saved.
[[nodiscard]] HttpResponse save_landmarks(const Asked& asked, const std::string& body);
/// Puts a mesh file into the folder under a name that is free. @throws InvalidInput, and nothing was kept, where it is
/// no mesh.
[[nodiscard]] HttpResponse save_mesh(const Asked& asked, const std::string& body);
/// Makes a folder for photographs in the served folder.
[[nodiscard]] HttpResponse make_photograph_folder(const Asked& asked, const std::string& body);
/// Puts a photograph into such a folder. @throws InvalidInput, and nothing was kept, where it is none, or is there.
[[nodiscard]] HttpResponse save_photograph(const Asked& asked, const std::string& body);
/// What a person may set in the project of a capture: crop, mask, scale, chart.
[[nodiscard]] HttpResponse answer_project(const Asked& asked);
/// Sets such members. @throws Conflict if the project was changed since it was read; InvalidInput, IoError,
/// CannotComplete, and nothing was saved.
[[nodiscard]] HttpResponse save_project(const Asked& asked, const std::string& body);
/// The mask of a capture, as large as its photographs. @throws NotFound if it has none.
[[nodiscard]] HttpResponse answer_mask(const Asked& asked);
/// Writes a new mask beside the project, which names it then. @throws as save_project()
[[nodiscard]] HttpResponse save_mask(const Asked& asked, const std::string& body);
/// How large a mesh is, and in which ways it can be aged.
[[nodiscard]] HttpResponse answer_begin(const Asked& asked);
/// Writes a scene file beside a mesh that ages it. @throws InvalidInput, IoError, CannotComplete
[[nodiscard]] HttpResponse begin_scene(const Asked& asked, const std::string& body);

/// Paints the control of a transfer. @throws InvalidInput, IoError, CannotComplete, Canceled
[[nodiscard]] HttpResponse paint_transfer(const Asked& asked, const std::string& body);

/// The commands that may be started, and what they may be given.
[[nodiscard]] HttpResponse answer_commands(const Asked& asked);
[[nodiscard]] HttpResponse answer_jobs(const Asked& asked);
/// The file that a job has made.
[[nodiscard]] HttpResponse answer_job_file(const Asked& asked);
/// Starts a job, or only looks whether it may be started. @throws WrongArgument; InvalidInput, IoError
[[nodiscard]] HttpResponse start_job(const Asked& asked, const std::string& body);
[[nodiscard]] HttpResponse cancel_job(const Asked& asked, const std::string& body);

using FileCheck = std::function<void(const std::filesystem::path& temporary)>;
/// Writes a file that came from outside if `check` takes it. @param name  What errors of the check call it.
/// @throws InvalidInput, CannotComplete, and nothing was written.
void write_checked(const std::filesystem::path& path, const std::string& name, const std::string& bytes,
                   const FileCheck& check);
/// A file as it is. @throws NotFound if files of its kind are not served.
[[nodiscard]] HttpResponse file_response(const std::filesystem::path& file);
/// Answer of `GET /api/place` about a place. @throws IoError
[[nodiscard]] Json place_json(const ServedFolder& folder, OpenedPlaces& opened, const std::filesystem::path& path,
                              PlaceKind kind);
/// Steps of an ingest, a registration or an unlit step: [{"name", "text", "pictures": [{"path", "caption"}]}]. Pictures
/// of another place have its "place".
[[nodiscard]] Json steps_json(const ServedFolder& folder, const std::filesystem::path& path, PlaceKind kind);

}  // namespace patinate::studio
