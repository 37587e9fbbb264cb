#include "tools/studio/studio.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/studio/client/assets.h"
#include "tools/studio/live_client.h"
#include "tools/studio/place.h"
#include "tools/studio/routes.h"
#include "tools/studio/session.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

/// The client loads nothing from elsewhere and is shown in no other page.
constexpr const char* kPagePolicy =
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; connect-src 'self' ws:; "
    "frame-src 'self'; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'";

HttpResponse secured(HttpResponse response) {
  const auto has = [&](const char* name) {
    return std::any_of(response.headers.begin(), response.headers.end(),
                       [&](const auto& h) { return h.first == name; });
  };
  response.headers.emplace_back("X-Content-Type-Options", "nosniff");
  response.headers.emplace_back("Referrer-Policy", "no-referrer");
  response.headers.emplace_back("Cross-Origin-Resource-Policy", "same-origin");
  response.headers.emplace_back("Cache-Control", "no-store");
  if (!has("Content-Security-Policy")) response.headers.emplace_back("Content-Security-Policy", kPagePolicy);
  return response;
}

constexpr std::string_view kMeshPath = "/api/mesh", kMaskPath = "/api/mask", kPhotographPath = "/api/photographs";

/// Text on the places that exist instead.
std::string known_text(const std::vector<std::string>& places) {
  constexpr std::size_t kMost = 8;
  if (places.empty()) return "nothing in this folder can be shown";
  std::string text = "there is " + places.front();
  for (std::size_t i = 1; i < std::min(kMost, places.size()); ++i) text += ", " + places[i];
  return places.size() > kMost ? text + " and " + std::to_string(places.size() - kMost) + " more" : text;
}

HttpResponse error_response(int status, const std::string& sentence) {
  return json_response(Json{{"error", sentence}}, status);
}

}  // namespace

HttpResponse json_response(const Json& json, int status) {
  // File names may be in any encoding.
  return {
      .status = status, .type = "application/json", .body = json.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

std::pair<fs::path, PlaceKind> Asked::place() const {
  const std::string name = target.value("place");
  const std::optional<fs::path> path = target.has("place") ? folder.find(name) : std::nullopt;
  const std::optional<PlaceKind> kind = path ? place_kind(*path) : std::nullopt;
  if (!kind) {
    std::vector<std::string> names;
    for (const PlaceEntry& entry : list_places(folder)) names.push_back(entry.place);
    throw NotFound("there is no place \"" + name + "\"; " + known_text(names) + did_you_mean(name, names));
  }
  return {*path, *kind};
}

std::shared_ptr<const SurfaceInTime> Asked::surface() const {
  const auto [path, kind] = place();
  return opened.open(path, kind);
}

fs::path Asked::file() const {
  const auto [path, kind] = place();
  const std::optional<fs::path> file = folder.find_below(path, target.value("path"));
  std::error_code error;
  if (!file || !fs::is_regular_file(*file, error))
    throw NotFound("there is no file \"" + target.value("path") + "\" in this place");
  return *file;
}

double Asked::number(const std::string& name, double low, double high) const {
  const std::optional<double> value = parse_number(target.value(name));
  if (!value || !(*value >= low && *value <= high)) {
    throw InvalidInput(name + ": found \"" + target.value(name) + "\"; expected a number from " +
                       short_number_text(low) + " to " + short_number_text(high));
  }
  return *value;
}

int Asked::integer(const std::string& name, int low, int high) const {
  const double value = number(name, low, high);
  if (value != static_cast<double>(static_cast<int>(value)))
    throw InvalidInput(name + ": found \"" + target.value(name) + "\"; expected a whole number");
  return static_cast<int>(value);
}

Studio::Studio(ServedFolder folder, StudioOptions options, std::function<void()> quit)
    : folder_(std::move(folder)),
      options_(std::move(options)),
      access_(options_.token, options_.port, options_.hosts),
      quit_(std::move(quit)),
      live_(folder_, {.num_threads = options_.num_threads, .open_device = options_.open_device}),
      jobs_{options_.commands, {folder_.path(), options_.program}} {}
Studio::~Studio() = default;

HttpResponse Studio::admit(const HttpRequest& request) const {
  if (access_.is_entry(request))
    return secured({.status = 303, .headers = {{"Set-Cookie", access_.cookie()}, {"Location", "/"}}});
  if (const std::string why = access_.refusal(request); !why.empty())
    return secured({.status = 403, .body = why + "\n"});
  return {.status = 0};
}

bool Studio::is_upload(const HttpRequest& request) {
  const std::string_view path = std::string_view(request.target).substr(0, request.target.find('?'));
  return request.method == "POST" && (path == kMeshPath || path == kMaskPath || path == kPhotographPath);
}

/// A table from method and path to what answers.
struct Studio::Routes {
  struct Route {
    std::string_view method, path;
    HttpResponse (*answer)(const Asked& asked);
  };
  static constexpr std::array kAnswers{Route{"GET", "/api/place", answer_place},
                                       Route{"GET", "/api/texture", answer_texture},
                                       Route{"GET", "/api/map", answer_map},
                                       Route{"GET", "/api/curve", answer_curve},
                                       Route{"GET", "/api/mesh", answer_mesh},
                                       Route{"GET", "/api/plants", answer_plants},
                                       Route{"GET", "/api/preview", answer_preview},
                                       Route{"GET", "/api/file", answer_file},
                                       Route{"GET", "/api/live", answer_live},
                                       Route{"GET", "/api/begin", answer_begin},
                                       Route{"GET", "/api/landmarks", answer_landmarks},
                                       Route{"GET", "/api/commands", answer_commands},
                                       Route{"GET", "/api/jobs", answer_jobs},
                                       Route{"GET", "/api/jobs/file", answer_job_file},
                                       Route{"GET", "/api/project", answer_project},
                                       Route{"GET", kMaskPath, answer_mask}};
  struct Taker {
    std::string_view path;
    HttpResponse (*take)(const Asked& asked, const std::string& body);
  };
  static constexpr std::array kTakers{
      Taker{"/api/landmarks", save_landmarks}, Taker{kMeshPath, save_mesh},
      Taker{"/api/begin", begin_scene},        Taker{"/api/paint", paint_transfer},
      Taker{"/api/jobs", start_job},           Taker{"/api/jobs/cancel", cancel_job},
      Taker{"/api/project", save_project},     Taker{kMaskPath, save_mask},
      Taker{kPhotographPath, save_photograph}, Taker{"/api/photographs/folder", make_photograph_folder}};

  static HttpResponse answer(Studio& studio, const HttpRequest& request, const RequestTarget& target,
                             const std::stop_token& gone) {
    const Asked asked{studio.folder_,
                      studio.opened_,
                      studio.live_,
                      studio.painted_,
                      studio.jobs_,
                      target,
                      {.on_progress = {}, .stop = gone, .num_threads = studio.options_.num_threads}};
    if (const StudioAsset* asset = request.method == "GET" ? find_studio_asset(target.path) : nullptr) {
      return {.type = std::string(asset->type), .body = std::string(asset->bytes)};
    }
    if (request.method == "GET" && target.path == "/api/places") return answer_places(asked, studio.options_.version);
    if (request.method == "POST" && target.path == "/api/session") {
      return {.type = "text/html; charset=utf-8", .body = make_session(asked, parse_session_options(request.body))};
    }
    for (const Taker& taker : kTakers) {
      if (request.method == "POST" && taker.path == target.path) return taker.take(asked, request.body);
    }
    if (request.method == "POST" && target.path == "/api/quit") {
      studio.quit_();
      return json_response(Json::object());
    }
    for (const Route& route : kAnswers) {
      if (route.path != target.path) continue;
      if (route.method != request.method) return error_response(405, "this address wants " + std::string(route.method));
      return route.answer(asked);
    }
    throw NotFound("there is nothing at " + target.path);
  }
};

HttpResponse Studio::answer(const HttpRequest& request, const std::stop_token& gone) noexcept {
  try {
    return secured(Routes::answer(*this, request, parse_target(request.target), gone));
  } catch (const NotFound& e) {
    return secured(error_response(404, e.what()));
  } catch (const Conflict& e) {
    return secured(error_response(409, e.what()));
  } catch (const WrongArgument& e) {
    return secured(json_response(Json{{"error", e.what()}, {"argument", e.key()}}, 400));
  } catch (const InputError& e) {
    return secured(error_response(400, e.what()));
  } catch (const std::bad_alloc&) {
    return secured(error_response(500, "not enough memory for this; ask for a smaller size"));
  } catch (const std::exception& e) {
    return secured(error_response(500, e.what()));
  }
}

std::string Studio::session(const SessionOptions& options, const RunControl& control) {
  const RequestTarget target;
  return make_session(Asked{folder_, opened_, live_, painted_, jobs_, target, control}, options);
}

std::shared_ptr<WebSocketListener> Studio::open(const HttpRequest& request,
                                                const std::shared_ptr<WebSocketPeer>& peer) noexcept {
  try {
    const RequestTarget target = parse_target(request.target);
    if (target.path != "/api/live") throw NotFound("there is nothing at " + target.path);
    const auto [path, kind] = Asked{folder_, opened_, live_, painted_, jobs_, target, {}}.place();
    if (!can_run(kind)) throw InvalidInput(kOnlyScenesRun);
    return live_.open(path, kind, peer);
  } catch (const std::exception& e) {
    refuse(*peer, e.what());
    return nullptr;
  }
}

}  // namespace patinate::studio
