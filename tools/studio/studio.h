/// \file
/// What the studio answers: docs/studio_protocol.md, without sockets.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "tools/studio/access.h"
#include "tools/studio/http.h"
#include "tools/studio/jobs.h"
#include "tools/studio/live_scene.h"
#include "tools/studio/painted_transfer.h"
#include "tools/studio/served_folder.h"
#include "tools/studio/surface_in_time.h"

namespace patinate::studio {

struct SessionOptions;

struct StudioOptions {
  std::string version;
  std::string token;
  int port = 0;
  std::vector<std::string> hosts;  ///< Names that are allowed as Host beside those of this machine.
  int num_threads = 0;             ///< Number of threads of one answer, and of a simulation; 0 = all.
  std::function<std::shared_ptr<const simulation::SimulationDevice>()> open_device =
      {};                        ///< Opens the device as LiveMeans does.
  JobCommands commands{{}, {}};  ///< That a browser may start.
  JobProgram program = {};       ///< With which; without a file, none are.
};

/// Thread-safe.
class Studio {
 public:
  Studio(ServedFolder folder, StudioOptions options, std::function<void()> quit);
  ~Studio();

  /// Answers that need no further question: the cookie, and refusals. Status 0 = continue.
  [[nodiscard]] HttpResponse admit(const HttpRequest& request) const;
  /// Whether what comes with a request may be large: a mesh, a photograph, a mask.
  [[nodiscard]] static bool is_upload(const HttpRequest& request);
  /// Never throws: what is wrong is an answer too.
  [[nodiscard]] HttpResponse answer(const HttpRequest& request, const std::stop_token& gone) noexcept;
  /// POST /api/session without a server. @throws as make_session().
  [[nodiscard]] std::string session(const SessionOptions& options, const RunControl& control);
  /// A WebSocket at /api/live. @returns nothing, after it has been told why, if its place cannot run.
  [[nodiscard]] std::shared_ptr<WebSocketListener> open(const HttpRequest& request,
                                                        const std::shared_ptr<WebSocketPeer>& peer) noexcept;

 private:
  struct Routes;
  ServedFolder folder_;
  StudioOptions options_;
  Access access_;
  std::function<void()> quit_;
  OpenedPlaces opened_;
  PaintedTransfers painted_;
  LiveScenes live_;
  Jobs jobs_;
};

}  // namespace patinate::studio
