#include "tools/studio/session.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"
#include "tools/studio/client/assets.h"
#include "tools/studio/outside_json.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

namespace {

constexpr std::size_t kMaxPageBytes = std::size_t{512} << 20;
constexpr std::size_t kMaxTimes = 2000;
constexpr int kMinSize = 16, kMaxSize = 8192;

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size())
    text.replace(at, what.size(), with);
  return text;
}

/// JSON that no element of a page ends or begins in, whatever names it holds.
std::string json_text(const Json& json) {
  return replaced(json.dump(-1, ' ', false, Json::error_handler_t::replace), "<", "\\u003c");
}

/// Puts `text` in the place of the one `mark` in the page.
void replace_once(std::string& page, std::string_view mark, const std::string& text) {
  const std::size_t at = page.find(mark);
  if (at == std::string::npos) throw CannotComplete("the client's page holds no " + std::string(mark));
  page.replace(at, mark.size(), text);
}

class SessionWriter {
 public:
  explicit SessionWriter(const Asked& asked) : asked_(asked) {}

  /// Adds the server's answer to this address.
  void add(const std::string& url, HttpResponse (*answer)(const Asked& asked)) {
    asked_.control.throw_if_stopped();
    const RequestTarget target = parse_target(url);
    add(url,
        answer(Asked{asked_.folder, asked_.opened, asked_.live, asked_.painted, asked_.jobs, target, asked_.control}));
  }
  void add(const std::string& url, const HttpResponse& response) {
    Json headers = Json::object();
    for (const auto& [name, value] : response.headers) headers[name] = value;
    text_ += (text_.empty() ? "" : ",\n") + json_text(url) + ":{\"type\":" + json_text(response.type) +
             ",\"headers\":" + json_text(headers) + ",\"base64\":\"" + base64(response.body) + "\"}";
    if (text_.size() > kMaxPageBytes)
      throw InvalidInput("the file would have more than 512 MB; ask for fewer times or a smaller size");
  }
  [[nodiscard]] std::string take() { return "{" + std::move(text_) + "}"; }

 private:
  const Asked& asked_;
  std::string text_;
};

/// The place without what needs a server.
Json trimmed(Json place) {
  place.erase("steps");
  place["maps"] = Json::array();
  place["frame_masks"] = false;
  return place;
}

/// Every n-th texel of the coordinates: a mean of two places is no place.
HttpResponse small_coordinates(const ImageF& all, int size) {
  const int n = std::max(1, (std::max(all.width(), all.height()) + size - 1) / size);
  ImageF some((all.width() + n - 1) / n, (all.height() + n - 1) / n, 2);
  for (int y = 0; y < some.height(); ++y) {
    for (int x = 0; x < some.width(); ++x) std::copy_n(all.pixel(x * n, y * n).begin(), 2, some.pixel(x, y).begin());
  }
  return {.type = "application/octet-stream",
          .headers = {{"X-Width", std::to_string(some.width())},
                      {"X-Height", std::to_string(some.height())},
                      {"X-Channels", "2"}},
          .body = {reinterpret_cast<const char*>(some.data()), some.values().size() * sizeof(float)}};
}

}  // namespace

SessionOptions parse_session_options(const std::string& body) {
  Json json;
  try {
    json = parse_outside_json(body);
  } catch (const IoError& e) {
    throw InvalidInput(std::string(e.what()) +
                       "; expected {\"place\": ..., \"times\": [...], \"size\": ..., \"view\": ...}");
  }
  JsonReader reader("session", json);
  SessionOptions options;
  options.place = reader.member("place").string();
  if (reader.has("times")) {
    for (const JsonReader& time : reader.member("times").elements(kMaxTimes)) options.times.push_back(time.number());
  }
  if (reader.has("size")) options.size = static_cast<int>(reader.member("size").integer(between(kMinSize, kMaxSize)));
  if (reader.has("view")) {
    (void)reader.member("view");
    options.view = json_text(json["view"]);
  }
  reader.finish();
  return options;
}

std::string make_session(const Asked& asked, const SessionOptions& options) {
  if (!has_studio_client())
    throw CannotComplete("this patinate was built without the studio's pages; install npm, configure and build again");
  const std::string place = percent_encoded(options.place);
  const RequestTarget named{"", {{"place", options.place}}};
  const Asked at{asked.folder, asked.opened, asked.live, asked.painted, asked.jobs, named, asked.control};
  const auto [path, kind] = at.place();
  const std::shared_ptr<const SurfaceInTime> surface = asked.opened.open(path, kind);
  const HistoryManifest& history = surface->history().manifest();
  std::vector<double> times = options.times;
  if (times.empty()) {
    for (const HistoryFrame& frame : history.frames) times.push_back(frame.time);
  }
  SessionWriter writer(asked);
  writer.add("/api/place?place=" + place, json_response(trimmed(place_json(asked.folder, asked.opened, path, kind))));
  if (kind != PlaceKind::History) writer.add("/api/mesh?place=" + place, answer_mesh);
  std::vector<std::string> shown{""};
  for (const SurfaceMap map : surface->material())
    shown.push_back("&map=" + std::string(kSurfaceMapNames[static_cast<std::size_t>(map)]));
  for (std::size_t i = 0; i < times.size(); ++i) {
    for (const std::string& map : shown) {
      writer.add("/api/texture?place=" + place + "&time=" + percent_encoded(number_text(times[i])) +
                     "&size=" + std::to_string(options.size) + map + "&format=png",
                 answer_texture);
    }
    asked.control.report(0.9 * static_cast<double>(i + 1) / static_cast<double>(times.size()));
  }
  const int map_size = std::max(1, options.size / 2);
  for (const ControlParameter& c : history.controls) {
    writer.add(
        "/api/map?place=" + place + "&name=control:" + percent_encoded(c.name) + "&size=" + std::to_string(map_size),
        answer_map);
  }
  if (kind == PlaceKind::Transfer)
    writer.add("/api/map?place=" + place + "&name=coordinates",
               small_coordinates(surface->transfer()->coordinates(), map_size));
  std::string page(find_studio_asset("/")->bytes);
  replace_once(page, "<link rel=\"stylesheet\" href=\"/studio.css\">",
               "<style>\n" + std::string(find_studio_asset("/studio.css")->bytes) + "</style>");
  // A deferred script of its own file runs after the page; inside the page it has to stand at its end.
  replace_once(page, "<script src=\"/studio.js\" defer></script>",
               "<script>\nwindow.PATINATE_SESSION={\"place\":" + json_text(options.place) +
                   ",\"view\":" + options.view + ",\"responses\":" + writer.take() + "};\n</script>\n<script>\n" +
                   replaced(std::string(find_studio_asset("/studio.js")->bytes), "</script", "<\\/script") +
                   "</script>");
  asked.control.report(1.0);
  return page;
}

}  // namespace patinate::studio
