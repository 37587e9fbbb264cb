#include "tools/patinate/info/capture_results.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "capture/calibration/calibrate.h"
#include "capture/registration/registration_io.h"
#include "capture/unlighting/unlight_job.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/light_io.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 4> kLengthUnits{"um", "mm", "cm", "m"};

fs::path file_in(const fs::path& path, const char* name) {
  std::error_code error;
  return fs::is_directory(path, error) ? path / name : path;
}

}  // namespace

Facts registration_facts(const fs::path& path) {
  check_registration(path);
  Json json = load_json(file_in(path, "registration.json"));
  update_spelling(json, 1, {{"free_motions", "unconstrained_dofs"}});
  Facts facts("registration");
  const Json& scans = json.at("scans");
  std::int64_t placed = 0;
  Json list = Json::array();
  for (const Json& scan : scans) {
    placed += scan.at("matrix").is_null() ? 0 : 1;
    list.push_back(Json{{"file", scan.at("file")}, {"status", scan.at("status")}});
  }
  facts.add("unit", json.at("unit"), json.at("unit").is_string() ? json.at("unit").get<std::string>() : "not said");
  facts.add("reference", json.at("reference").get<std::string>());
  std::string table = std::to_string(scans.size()) + ", " + std::to_string(placed) + " of them placed";
  for (const std::string& line : capture::registration_table(json)) table += "\n    " + line;
  facts.add("scans", list, table);
  facts.add("pairs", static_cast<std::int64_t>(json.at("pairs").size()));
  facts.add("key", json.at("key").get<std::string>());
  return facts;
}

Facts unlit_facts(const fs::path& path) {
  const capture::UnlitDocument unlit = capture::read_unlit(path);
  Facts facts("unlit");
  if (!unlit.name.empty()) facts.add("name", unlit.name);
  facts.add("size", Json{unlit.width, unlit.height},
            size_text(unlit.width, unlit.height) + (unlit.channels == 1 ? ", gray" : ""));
  facts.add("lights", static_cast<std::int64_t>(unlit.lights.size()));
  facts.add(
      "determined_pixels", unlit.num_determined,
      std::to_string(unlit.num_determined) + " of " + std::to_string(unlit.num_surface) + " that show the surface");
  facts.add("residual", unlit.residual, percent_text(unlit.residual));
  Json names = Json::array();
  std::string shown;
  for (const capture::UnlitMap& map : unlit.maps) {
    names.push_back(map.name);
    shown += (shown.empty() ? "" : ", ") + map.name;
  }
  facts.add("maps", names, shown);
  shown.clear();
  for (const std::string& note : unlit.notes) shown += "\n    " + note;
  facts.add("notes", unlit.notes, unlit.notes.empty() ? "" : std::to_string(unlit.notes.size()) + shown);
  facts.add("key", unlit.key);
  return facts;
}

Facts calibration_facts(const fs::path& path) {
  const Json content = load_json(path);
  JsonReader json(path.string(), content);
  json.expect_format("patinate.calibration", 1);
  Facts facts("calibration");
  facts.add("calibrated",
            std::string(capture::kCalibrationKindNames[json.member("kind").choice(capture::kCalibrationKindNames)]));
  facts.add("unit", json.member("unit").string());
  if (json.has("camera")) {
    const Camera camera = read_camera(path);
    const CameraParameters& p = camera.parameters();
    facts.add("camera", json_of(camera),
              size_text(p.width, p.height) + ", focal lengths " + short_number_text(p.fx) + " and " +
                  short_number_text(p.fy) + " px");
  }
  if (json.has("lights")) {
    const std::vector<Light> lights = read_lights(path, 1.0);
    const auto near =
        std::count_if(lights.begin(), lights.end(), [](const Light& light) { return light.kind == Light::Kind::Near; });
    facts.add("lights", static_cast<std::int64_t>(lights.size()),
              std::to_string(lights.size()) + ", " + std::to_string(near) + " of them near");
  }
  if (json.has("response")) {
    const Json& response = content.at("response");
    facts.add("response", response, response.is_string() ? response.get<std::string>() : response.dump());
  }
  return facts;
}

void check_registration(const fs::path& path) {
  const fs::path file = file_in(path, "registration.json");
  Json content = load_json(file);
  update_spelling(content, 1, {{"free_motions", "unconstrained_dofs"}});
  JsonReader json(file.string(), content);
  json.expect_format("patinate.registration", 2);
  if (!json.member("unit").is_null()) (void)json.member("unit").choice(kLengthUnits);
  std::vector<std::string> names;
  for (JsonReader scan : json.member("scans").elements()) {
    names.push_back(scan.member("file").string());
    if (names.back().empty() || fs::path(names.back()).filename() != names.back())
      scan.member("file").fail("the name of a file, without its folder");
    (void)scan.member("status").string();
    (void)scan.member("residual").number(at_least(0));
    (void)scan.member("overlap").number(between(0, 1));
    for (const JsonReader& motion : scan.member("unconstrained_dofs").elements()) (void)motion.string();
    const auto rows_of = [](const JsonReader& matrix, std::size_t size) {
      const std::vector<JsonReader> rows = matrix.elements(size);
      if (rows.size() != size) matrix.fail(std::to_string(size) + " rows of " + std::to_string(size) + " numbers");
      std::vector<double> all;
      for (const JsonReader& row : rows) {
        for (const double v : row.numbers(size)) all.push_back(v);
      }
      return all;
    };
    (void)rows_of(scan.member("covariance"), 6);
    const JsonReader matrix = scan.member("matrix");
    if (matrix.is_null()) continue;
    const std::vector<double> v = rows_of(matrix, 4);
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> m(v.data());
    const Eigen::Matrix3d r = m.topLeftCorner<3, 3>();
    constexpr double kRigid = 1e-6;
    if (!((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < kRigid) || !(r.determinant() > 0.0) ||
        m.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      matrix.fail("a rotation and a shift");
    }
  }
  const auto require_scan = [&](const JsonReader& name) {
    if (std::find(names.begin(), names.end(), name.string()) == names.end()) name.fail("one of the scans");
  };
  require_scan(json.member("reference"));
  for (JsonReader pair : json.member("pairs").elements()) {
    require_scan(pair.member("target"));
    require_scan(pair.member("source"));
  }
  JsonReader closure = json.member("closure");
  for (const char* name : {"median_deg", "median", "largest_deg", "largest"})
    (void)closure.member(name).number(at_least(0));
  (void)json.member("key").string();
}

void check_unlit(const fs::path& path) {
  const capture::UnlitDocument unlit = capture::read_unlit(path);
  for (const capture::UnlitMap& map : unlit.maps) {
    int width = 0, height = 0;
    if (map.name == "mask") {
      const ImageU8 mask = read_mask(map.file);
      width = mask.width(), height = mask.height();
    } else {
      const std::vector<std::string> color =
          unlit.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
      const ImageF image =
          read_channels(map.file, map.name == "normal"      ? std::vector<std::string>{"X", "Y", "Z"}
                                  : map.name == "specular"  ? std::vector<std::string>{"strength", "roughness"}
                                  : map.name == "metalness" ? std::vector<std::string>{"Y"}
                                                            : color);
      width = image.width(), height = image.height();
    }
    if (width != unlit.width || height != unlit.height) {
      throw IoError(map.file.string(),
                    "is " + size_text(width, height) + "; unlight.json says " + size_text(unlit.width, unlit.height));
    }
  }
}

void check_calibration(const fs::path& path) { (void)calibration_facts(path); }

}  // namespace patinate::cli
