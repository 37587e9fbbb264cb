#include "capture/project/given_transforms.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"

namespace patinate::capture {

int find_photo(const CaptureProject& project, const std::string& name, const std::string& what) {
  const std::vector<std::string> names = photo_names(project.frames);
  int found = -1;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<int>(i);
    if (project.frames[i].file.filename().string() != name) continue;
    if (found >= 0)
      throw IoError(project.file.string(),
                    what + " names " + name + ", which several photographs are; give one as " + names[i]);
    found = static_cast<int>(i);
  }
  if (found < 0)
    throw IoError(project.file.string(), what + " names " + name + ", which is none of its photographs (" +
                                             names.front() + (names.size() > 1 ? ", " + names[1] + " ..." : "") + ")");
  return found;
}

void read_transforms(const std::filesystem::path& file, CaptureProject& project) {
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  json.expect_format("patinate.alignment", 1);
  const std::vector<std::string> names = photo_names(project.frames);
  const auto index_of = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  if (project.align.to.empty()) project.align.to = json.member("reference").string();
  if (json.member("reference").string() != project.align.to)
    json.member("reference").fail("the project's `align_to`, " + project.align.to);
  for (JsonReader& entry : json.member("photos").elements()) {
    const std::size_t i = index_of(entry.member("photo").string());
    if (i == names.size() || project.frames[i].transform || !entry.has("transform")) continue;
    project.frames[i].transform = read_transform(entry.member("transform"));
  }
}

}  // namespace patinate::capture
