// What a person sets in the project of a capture with a photograph in view: crop, mask, scale and color chart.
#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/json_text.h"
#include "libcommon/core/text.h"
#include "libcommon/image/picture_bytes.h"
#include "patinate/image/image_io.h"
#include "tools/studio/opened_capture.h"
#include "tools/studio/outside_json.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr const char* kMaskFolder = "masks";  ///< A name in the photographs' own folder may match their pattern.

struct OpenedProject {
  fs::path file;
  std::string text;
  std::string state;  ///< Content of the file.
  capture::CaptureProject project;
};

OpenedProject open_project(const Asked& asked) {
  const fs::path file = fixed_capture_file(asked);
  OpenedProject opened{.file = file, .text = read_file(file), .state = {}, .project = {}};
  ContentHash state;
  state.add(opened.text);
  opened.state = state.hex();
  opened.project = capture::read_capture_project(file);
  return opened;
}

/// The one that was read when the page was made. @throws Conflict
OpenedProject open_project(const Asked& asked, const std::string& state) {
  OpenedProject opened = open_project(asked);
  if (opened.state != state)
    throw Conflict(asked.folder.name_of(opened.file) +
                   ": the project was changed since this page read it; nothing was saved. Load the page again");
  return opened;
}

bool is_as_large(const capture::CaptureProject& project, int width, int height) {
  return width == project.photo_width && height == project.photo_height;
}

Json member_of(const OpenedProject& opened, const char* name) {
  const Json json = parse_json(opened.file.string(), opened.text);
  return json.contains(name) ? json.at(name) : Json(nullptr);
}

Json project_json(const OpenedProject& opened) {
  const capture::CaptureProject& project = opened.project;
  bool may_edit = false;  // A mask as large as the history is not painted further here.
  if (project.mask) {
    const ImageInfo info = probe_image(*project.mask);
    may_edit = is_as_large(project, info.width, info.height);
  }
  const auto& frame = project.frames[static_cast<std::size_t>(project.reference)];
  return {{"state", opened.state},
          {"photos", photos_json(project)},
          {"reference", project.is_handheld() ? Json(frame.number) : Json(nullptr)},
          {"width", project.photo_width},
          {"height", project.photo_height},
          {"file", opened.file.filename().string()},
          {"roi", member_of(opened, "roi")},
          {"mask", member_of(opened, "mask")},
          {"is_mask_shown", may_edit},
          {"texel_size_mm", member_of(opened, "texel_size_mm")},
          {"chart", member_of(opened, "chart")}};
}

/// "auto", or corners; all else that the project says of its chart stays.
Json chart_with(const Json& chart, JsonReader given) {
  Json made = chart.is_object() ? chart : Json::object();
  if (given.is_string()) {
    static constexpr std::array<std::string_view, 1> kAuto{"auto"};
    (void)given.choice(kAuto);
    made.erase("corners");
    return made.empty() ? Json("auto") : made;
  }
  made["corners"] = Json::array();
  for (const JsonReader& corner : given.member("corners").elements(4))
    made["corners"].push_back(corner.numbers(2, between(-0.5, 65536)));
  given.finish();
  return made;
}

/// The text with what a browser sent; null takes a member out.
std::string text_with(const OpenedProject& opened, JsonReader members) {
  std::string text = opened.text;
  const auto set = [&](const char* name, const auto& value_of) {
    if (!members.has(name)) return;
    const JsonReader given = members.member(name);
    text = given.is_null() ? without_member(text, name) : with_member(text, name, Json(value_of(given)).dump());
  };
  set("roi", [](const JsonReader& given) {
    Json roi = Json::array();
    for (const JsonReader& number : given.elements(4)) roi.push_back(number.integer(between(0, 65536)));
    return roi;
  });
  set("mask", [](const JsonReader& given) -> Json { given.fail("null; /api/mask takes a mask"); });
  set("texel_size_mm", [](const JsonReader& given) { return given.number(above(0)); });
  set("chart", [&](const JsonReader& given) { return chart_with(member_of(opened, "chart"), given); });
  members.finish();
  return text;
}

/// Puts a text in the place of the project if it can be read with it.
void replace_text(const OpenedProject& opened, const std::string& text) {
  if (text == opened.text) return;
  write_checked(opened.file, opened.file.filename().string(), text, [&](const fs::path& temporary) {
    const capture::CaptureProject project = capture::read_capture_project(temporary);
    if (project.frames.size() != opened.project.frames.size())
      throw InvalidInput("its photographs are not the same any more; load the page again");
  });
}

}  // namespace

HttpResponse answer_project(const Asked& asked) { return json_response(project_json(open_project(asked))); }

HttpResponse save_project(const Asked& asked, const std::string& body) {
  const Json json = parse_outside_json(body);
  JsonReader reader("project", json);
  const std::string state = reader.member("state").string();
  const std::lock_guard lock(project_mutex());
  const OpenedProject opened = open_project(asked, state);
  const std::string text = text_with(opened, reader.member("members"));
  reader.finish();
  replace_text(opened, text);
  return json_response(project_json(open_project(asked)));
}

HttpResponse answer_mask(const Asked& asked) {
  const OpenedProject opened = open_project(asked);
  if (!opened.project.mask) throw NotFound("this project has no mask");
  return {.type = "image/png", .body = png_of(read_mask(*opened.project.mask))};
}

HttpResponse save_mask(const Asked& asked, const std::string& body) {
  const std::lock_guard lock(project_mutex());
  const OpenedProject opened = open_project(asked, asked.target.value("state"));
  const fs::path folder = opened.file.parent_path() / kMaskFolder;
  const std::string stem = opened.file.stem() == "capture" ? "mask" : opened.file.stem().string() + "_mask";
  std::error_code error;
  const bool is_new = fs::create_directory(folder, error);
  fs::path path;
  try {
    path = asked.folder.make_file(asked.folder.name_of(folder), stem, ".png");
    write_checked(path, "mask", body, [&](const fs::path& temporary) {
      const ImageU8 mask = read_mask(temporary);
      if (!is_as_large(opened.project, mask.width(), mask.height()))
        throw InvalidInput("is " + size_text(mask.width(), mask.height()) + " pixels; expected " +
                           size_text(opened.project.photo_width, opened.project.photo_height) + ", as the photographs");
      const auto values = mask.values();
      if (std::none_of(values.begin(), values.end(), [](std::uint8_t v) { return v != 0; }))
        throw InvalidInput("leaves nothing inside");
      write_codes(temporary, mask);  // Only what is inside stays of what came.
    });
    const std::string name = std::string(kMaskFolder) + "/" + path.filename().string();
    replace_text(opened, with_member(opened.text, "mask", Json(name).dump()));
  } catch (...) {
    if (!path.empty()) fs::remove(path, error);
    if (is_new) fs::remove(folder, error);
    throw;
  }
  return json_response(project_json(open_project(asked)));
}

}  // namespace patinate::studio
