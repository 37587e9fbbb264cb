// Points that a person marks in the photographs of a capture: read from the project's table, and saved to it.
#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/handheld/landmarks.h"
#include "capture/project/capture_project.h"
#include "capture/project/given_transforms.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/json_text.h"
#include "tools/studio/opened_capture.h"
#include "tools/studio/outside_json.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxMarks = 20'000, kLongestName = 64;

/// A project whose photographs are marked, as it lies on the disk now.
struct MarkedCapture {
  fs::path file;
  std::string text;  ///< Text of the project.
  capture::CaptureProject project;
  std::map<std::string, capture::PhotoMarks> marks;  ///< All of the table, by photo_names() where they are known.
  std::string state;                                 ///< Content of project and table.

  [[nodiscard]] bool uses_marks() const {
    using capture::AlignMethod;
    const AlignMethod method = project.align.method;
    return method == AlignMethod::Auto || method == AlignMethod::Landmarks;
  }
};

/// "auto" of the project itself; "off" where it says nothing.
std::string said_method(const std::string& file, const std::string& text) {
  const Json json = parse_json(file, text);
  return json.is_object() && json.contains("align") && json.at("align").is_string()
             ? json.at("align").get<std::string>()
             : "off";
}

/// By their names in the project; others, of photographs that are left out, stay as the table has them.
std::map<std::string, capture::PhotoMarks> known_marks(const capture::CaptureProject& project, const fs::path& table) {
  const std::vector<std::string> names = capture::photo_names(project.frames);
  std::map<std::string, capture::PhotoMarks> marks;
  for (auto& [name, points] : capture::read_landmarks(table)) {
    std::string known = name;
    const bool is_file = std::any_of(project.frames.begin(), project.frames.end(), [&](const capture::CapturePhoto& p) {
      return p.file.filename().string() == name;
    });
    if (is_file) known = names[capture::find_photo(project, name, "a landmark")];
    marks[known].insert(points.begin(), points.end());
  }
  return marks;
}

/// The project's table has to lie where the studio may write.
void require_inside(const Asked& asked, const fs::path& table) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(table, error);
  const fs::path below = error ? fs::path("..") : real.lexically_relative(asked.folder.path());
  if (below.empty() || *below.begin() == "..")
    throw InvalidInput(table.string() + ": the project's table of landmarks lies outside of the folder that is served");
}

MarkedCapture open_marked(const Asked& asked) {
  const fs::path file = fixed_capture_file(asked);
  MarkedCapture marked{.file = file, .text = read_file(file), .project = {}, .marks = {}, .state = {}};
  // Photographs of several sizes are no reason not to mark them.
  const bool is_off = said_method(file.string(), marked.text) == "off";
  using Method = capture::AlignOptions::Method;
  marked.project = capture::read_capture_project(file, {.method = is_off ? Method::Auto : Method::Project});
  if (is_off) marked.project.align.method = capture::AlignMethod::Off;
  ContentHash state;
  state.add(marked.text);
  const std::optional<fs::path>& table = marked.project.align.landmarks;
  std::error_code error;
  if (table) require_inside(asked, *table);
  if (table && fs::exists(*table, error)) {
    marked.marks = known_marks(marked.project, *table);
    state.add_file(*table);
  }
  marked.state = state.hex();
  return marked;
}

Json json_of(const MarkedCapture& marked) {
  const capture::CaptureProject& project = marked.project;
  const std::vector<std::string> names = capture::photo_names(project.frames);
  Json marks = Json::array();
  for (std::size_t i = 0; i < project.frames.size(); ++i) {
    const capture::CapturePhoto& photo = project.frames[i];
    if (shown_path(marked.file.parent_path(), photo.file).empty()) continue;  // A photograph elsewhere.
    const auto found = marked.marks.find(names[i]);
    if (found == marked.marks.end()) continue;
    for (const auto& [point, at] : found->second)
      marks.push_back({{"photo", photo.number}, {"point", point}, {"x", at.x()}, {"y", at.y()}});
  }
  return {{"state", marked.state},
          {"align", capture::align_method_text(project.align.method)},
          {"uses_marks", marked.uses_marks()},
          {"table", project.align.landmarks ? Json(project.align.landmarks->filename().string()) : Json(nullptr)},
          {"photos", photos_json(project)},
          {"marks", std::move(marks)}};
}

/// Replaces the marks of the project's photographs by what a browser sent.
void take_marks(const JsonReader& list, MarkedCapture& marked) {
  const capture::CaptureProject& project = marked.project;
  const std::vector<std::string> names = capture::photo_names(project.frames);
  for (const std::string& name : names) marked.marks.erase(name);
  for (JsonReader& mark : list.elements(kMaxMarks)) {
    const auto number = mark.member("photo").integer();
    const auto photo = std::find_if(project.frames.begin(), project.frames.end(),
                                    [&](const capture::CapturePhoto& p) { return p.number == number; });
    if (photo == project.frames.end()) mark.member("photo").fail("the number of one of the project's photographs");
    const std::string point = mark.member("point").string();
    if (point.empty() || point.size() > kLongestName)
      mark.member("point").fail("a name of at most " + std::to_string(kLongestName) + " bytes");
    const double x = mark.member("x").number(between(-0.5, photo->width - 0.5)),
                 y = mark.member("y").number(between(-0.5, photo->height - 0.5));
    mark.finish();
    const auto index = static_cast<std::size_t>(photo - project.frames.begin());
    if (!marked.marks[names[index]].emplace(point, Eigen::Vector2d(x, y)).second)
      mark.fail("each point once in a photograph");
  }
}

/// A table that is no file of the user's.
fs::path new_table(const fs::path& folder) {
  std::error_code error;
  for (int k = 1;; ++k) {
    fs::path table = folder / ("landmarks" + (k == 1 ? std::string() : "-" + std::to_string(k)) + ".csv");
    if (fs::symlink_status(table, error).type() == fs::file_type::not_found) return table;
  }
}

/// The table first: a project never names one that is not there.
void save_marks(const MarkedCapture& marked) {
  const std::string table_text = capture::landmarks_text(marked.marks);
  const bool is_named = marked.project.align.landmarks.has_value();
  const fs::path table = is_named ? *marked.project.align.landmarks : new_table(marked.file.parent_path());
  std::string text = marked.text;
  if (!is_named) text = with_member(text, "landmarks", Json(table.filename().string()).dump());
  if (!marked.uses_marks()) text = with_member(text, "align", "\"auto\"");
  write_atomically(table, table_text);
  try {
    if (text != marked.text) write_atomically(marked.file, text);
  } catch (...) {
    std::error_code error;
    if (!is_named) fs::remove(table, error);
    throw;
  }
}

}  // namespace

HttpResponse answer_landmarks(const Asked& asked) { return json_response(json_of(open_marked(asked))); }

HttpResponse save_landmarks(const Asked& asked, const std::string& body) {
  const Json json = parse_outside_json(body);
  JsonReader reader("landmarks", json);
  const std::string state = reader.member("state").string();
  const std::lock_guard lock(project_mutex());
  MarkedCapture marked = open_marked(asked);
  if (state != marked.state)
    throw Conflict(marked.file.string() +
                   ": the project or its table of landmarks was changed since this page read it; nothing was saved. "
                   "Load the page again and mark the points there");
  take_marks(reader.member("marks"), marked);
  reader.finish();
  save_marks(marked);
  return json_response(json_of(open_marked(asked)));
}

}  // namespace patinate::studio
