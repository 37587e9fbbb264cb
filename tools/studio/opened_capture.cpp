#include "tools/studio/opened_capture.h"

#include <nlohmann/json.hpp>

#include "capture/project/relit_project.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"

namespace patinate::studio {

namespace fs = std::filesystem;

fs::path fixed_capture_file(const Asked& asked) {
  const auto [path, kind] = asked.place();
  const fs::path file = capture::capture_file(path);
  if (kind != PlaceKind::Ingest || capture::is_relit_capture(file))
    throw InvalidInput("this needs the photographs of one surface; the place is no such capture project");
  return file;
}

std::mutex& project_mutex() {
  static std::mutex mutex;
  return mutex;
}

std::string shown_path(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  const fs::path relative = fs::weakly_canonical(file, error).lexically_relative(fs::weakly_canonical(folder, error));
  return relative.empty() || *relative.begin() == ".." ? "" : relative.generic_string();
}

Json photo_json(const fs::path& folder, const capture::CapturePhoto& photo, const std::string& name) {
  const std::string path = shown_path(folder, photo.file);
  if (path.empty()) return nullptr;
  Json json{{"name", name}, {"path", path}, {"width", photo.width}, {"height", photo.height}};
  if (photo.stream) json["image"] = photo.image;
  return json;
}

Json photos_json(const capture::CaptureProject& project) {
  const std::vector<std::string> names = capture::photo_names(project.frames);
  Json photos = Json::array();
  for (std::size_t i = 0; i < project.frames.size(); ++i) {
    const capture::CapturePhoto& photo = project.frames[i];
    Json json = photo_json(project.file.parent_path(), photo, names[i]);
    if (json.is_null()) continue;
    json["number"] = photo.number;
    json["time"] = short_number_text(photo.time) + " " + shown_time_unit(project.time_unit);
    photos.push_back(std::move(json));
  }
  return photos;
}

}  // namespace patinate::studio
