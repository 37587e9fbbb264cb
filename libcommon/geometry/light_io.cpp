#include "libcommon/geometry/light_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/core/text_lines.h"
#include "libcommon/geometry/length_unit.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxLights = 100'000;
constexpr double kDirectionSlack = 0.05;
constexpr std::array<std::string_view, 2> kKindNames{"directions", "positions"};
constexpr std::array<std::string_view, 2> kFrameNames{"camera", "scanner"};

/// From the axes of photographs of lights (x right, y up, z to the camera) to those of our cameras, and back.
Vec3 flipped(const Vec3& v) { return {v.x(), -v.y(), -v.z()}; }

struct Row {
  Vec3 numbers;
  std::string name;
  TextLines::Line line;
};

std::optional<Vec3> three_numbers(std::span<const std::string_view> words) {
  Vec3 numbers;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<double> number = parse_number(words[i]);
    if (!number) return std::nullopt;
    numbers[static_cast<Eigen::Index>(i)] = *number;
  }
  return numbers;
}

/// Three lines of equally many numbers, a column for each light; nothing when the lines are something else.
std::vector<Row> columns_of(std::span<const TextLines::Line> lines) {
  std::vector<Row> rows;
  if (lines.size() != 3) return rows;
  std::array<std::vector<std::string_view>, 3> words;
  for (std::size_t i = 0; i < 3; ++i) words[i] = words_of(lines[i].text);
  if (words[0].size() == 3 || words[0].size() != words[1].size() || words[0].size() != words[2].size()) return rows;
  for (std::size_t i = 0; i < words[0].size(); ++i) {
    const auto numbers = three_numbers(std::array{words[0][i], words[1][i], words[2][i]});
    if (!numbers) return {};
    rows.push_back({*numbers, "", lines[0]});
  }
  return rows;
}

/// Three rows of three numbers can be read both ways: the one in which every light has length 1.
void turn_if_columns(std::vector<Row>& rows, const TextLines& text) {
  if (rows.size() != 3 || std::any_of(rows.begin(), rows.end(), [](const Row& row) { return !row.name.empty(); }))
    return;
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i) m.row(i) = rows[i].numbers.transpose();
  static constexpr double kUnit = 1e-3;
  const auto are_units = [](const auto& lengths) { return ((lengths.array() - 1.0).abs() < kUnit).all(); };
  const bool by_rows = are_units(m.rowwise().norm().eval()), by_columns = are_units(m.colwise().norm().eval());
  if (by_rows && by_columns && !m.isApprox(m.transpose(), kUnit)) {
    throw IoError(
        text.file(),
        "three lights in a 3 x 3 table can be read by rows or by columns; put the number 3 in a line above for rows");
  }
  if (by_columns && !by_rows) {
    for (int i = 0; i < 3; ++i) rows[i].numbers = m.col(i);
  }
}

std::vector<Row> rows_of(const TextLines& text, const LightRows& options) {
  std::vector<TextLines::Line> lines;
  for (const TextLines::Line& line : text.lines()) {
    if (!line.is_empty()) lines.push_back(line);
  }
  if (lines.empty()) throw IoError(text.file(), "holds no light; expected a line `NAME x y z` for each");
  std::optional<double> count;
  const TextLines::Line first = lines.front();
  const std::vector<std::string_view> first_words = words_of(first.text, 3);
  // Some programs for virtual domes write the number of further parameters after it.
  if (first_words.size() == 1 || (first_words.size() == 2 && first_words[1] == "0")) {
    count = parse_number(first_words[0]);
    if (!count || !(*count >= 1 && *count <= static_cast<double>(kMaxLights) && *count == std::floor(*count))) {
      text.fail(first, "is no number of lights; expected 1 to " + std::to_string(kMaxLights));
    }
    lines.erase(lines.begin());
  }
  if (!count) {
    std::vector<Row> columns = columns_of(lines);
    if (!columns.empty()) return columns;
  }
  if (lines.size() > kMaxLights)
    throw IoError(text.file(), "holds more than " + std::to_string(kMaxLights) + " lights");
  if (count && *count != static_cast<double>(lines.size())) {
    throw IoError(text.file(), "line " + std::to_string(first.number) + " says " + number_text(*count) +
                                   " lights, but " + std::to_string(lines.size()) + " follow");
  }
  std::vector<Row> rows;
  for (const TextLines::Line& line : lines) {
    const std::vector<std::string_view> words = words_of(line.text);
    const auto numbers = words.size() < 3 ? std::nullopt : three_numbers(std::span(words).last(3));
    if (!numbers) text.fail(line, "expected `NAME x y z`, or three numbers");
    const auto name_size = static_cast<std::size_t>(words[words.size() - 3].data() - line.text.data());
    rows.push_back({*numbers, std::string(line.text.substr(0, name_size)), line});
    while (!rows.back().name.empty() && (rows.back().name.back() == ' ' || rows.back().name.back() == '\t'))
      rows.back().name.pop_back();
  }
  if (!count && options.kind == LightRows::Kind::Directions) turn_if_columns(rows, text);
  return rows;
}

Light light_of(const Row& row, const TextLines& text, double mm_per_unit, const Camera* camera,
               const LightRows& options) {
  Light light;
  light.name = row.name;
  light.is_intensity_known = false;
  const bool in_camera = options.frame == LightRows::Frame::Camera;
  if (in_camera && camera == nullptr) {
    throw IoError(
        text.file(),
        "gives lights in the camera's frame, and there is no camera; give one, or say \"frame\": \"scanner\"");
  }
  if (options.kind == LightRows::Kind::Positions) {
    light.kind = Light::Kind::Near;
    const Vec3 mm = mm_per_unit * row.numbers;
    if (!mm.allFinite()) text.fail(row.line, "is out of range");
    light.position = in_camera ? Vec3(camera->center() + camera->parameters().rotation.transpose() * flipped(mm)) : mm;
    return light;
  }
  light.kind = Light::Kind::Directional;
  const double length = row.numbers.norm();
  if (!(length > 0)) text.fail(row.line, "the direction has length 0");
  if (!(std::abs(length - 1.0) <= kDirectionSlack)) {
    text.fail(row.line, "the direction has length " + short_number_text(length) +
                            "; expected 1, or \"kind\": \"positions\" if these are positions");
  }
  const Vec3 direction = row.numbers / length;
  light.direction = in_camera ? Vec3(camera->parameters().rotation.transpose() * flipped(direction)) : direction;
  return light;
}

Light read_light(JsonReader json, double mm_per_unit) {
  Light light;
  const bool is_near = json.has("position");
  if (is_near == json.has("direction")) json.fail("a light with either `position` or `direction`");
  const JsonReader where = json.member(is_near ? "position" : "direction");
  const std::vector<double> v = where.numbers(3);
  light.kind = is_near ? Light::Kind::Near : Light::Kind::Directional;
  const Vec3 numbers(v[0], v[1], v[2]);
  if (is_near) {
    light.position = mm_per_unit * numbers;
    if (!light.position.allFinite()) where.fail("a position within reach");
  } else {
    const double length = numbers.stableNorm();
    if (!(length > 0) || !std::isfinite(length)) where.fail("a direction, of a length above 0");
    light.direction = numbers / length;
  }
  light.is_intensity_known = json.has("intensity");
  if (light.is_intensity_known) {
    const std::vector<double> rgb = json.member("intensity").numbers(3, above(0));
    light.intensity = {rgb[0], rgb[1], rgb[2]};
  }
  if (json.has("name")) light.name = json.member("name").string();
  json.finish();
  return light;
}

/// Without folders, as any system writes them, and without quotation marks around all of it.
std::string last_part(std::string name) {
  if (name.size() > 1 && (name.front() == '"' || name.front() == '\'') && name.front() == name.back())
    name = name.substr(1, name.size() - 2);
  return name.substr(name.find_last_of("/\\") + 1);  // From the first character on where there is none.
}

/// Lights that a photograph's name means, by the strictest comparison that finds one.
std::vector<std::size_t> lights_named(const std::vector<Light>& lights, const std::string& photo) {
  const auto stem = [](const std::string& name) { return std::filesystem::path(name).stem().string(); };
  const std::array<std::function<bool(const std::string&)>, 4> comparisons{
      [&](const std::string& name) { return name == photo; },
      [&](const std::string& name) { return last_part(name) == photo; },
      [&](const std::string& name) { return lower_case(last_part(name)) == lower_case(photo); },
      [&](const std::string& name) {
        const std::string last = lower_case(last_part(name)), plain = lower_case(stem(photo));
        return !last.empty() && (last == plain || stem(last) == plain);
      }};
  std::vector<std::size_t> found;
  for (const auto& is_same : comparisons) {
    for (std::size_t k = 0; k < lights.size(); ++k) {
      if (is_same(lights[k].name)) found.push_back(k);
    }
    if (!found.empty()) break;
  }
  return found;
}

std::vector<Light> read_array(const JsonReader& json, double mm_per_unit) {
  std::vector<Light> lights;
  for (const JsonReader& entry : json.elements(kMaxLights)) lights.push_back(read_light(entry, mm_per_unit));
  if (lights.empty()) json.fail("at least one light");
  return lights;
}

std::vector<Light> read_json_file(const std::filesystem::path& path, double mm_per_unit) {
  const Json content = load_json(path);
  JsonReader json(path.string(), content);
  if (json.is_array()) return read_array(json, mm_per_unit);
  json.expect_format("patinate.calibration", 1);
  const double mm = kMmPerLengthUnit[json.member("unit").choice(kLengthUnitNames)];
  if (!json.has("lights")) throw IoError(path.string(), "is a calibration without lights");
  return read_array(json.member("lights"), mm);
}

}  // namespace

std::vector<Light> read_lights(const std::filesystem::path& path, double mm_per_unit, const Camera* camera_mm,
                               const LightRows& rows) {
  if (path.extension() == ".json") return read_json_file(path, mm_per_unit);
  const TextLines text(path);
  std::vector<Light> lights;
  for (const Row& row : rows_of(text, rows)) lights.push_back(light_of(row, text, mm_per_unit, camera_mm, rows));
  return lights;
}

std::vector<Light> read_lights(JsonReader json, double mm_per_unit, const Camera* camera_mm) {
  if (json.is_string()) return read_lights(json.path(), mm_per_unit, camera_mm);
  if (json.is_array()) return read_array(json, mm_per_unit);
  if (!json.is_object()) json.fail("an array of lights, the path of an .lp or .json file, or an object with `file`");
  const std::filesystem::path path = json.member("file").path();
  LightRows options;
  if (json.has("kind")) options.kind = static_cast<LightRows::Kind>(json.member("kind").choice(kKindNames));
  if (json.has("frame")) options.frame = static_cast<LightRows::Frame>(json.member("frame").choice(kFrameNames));
  json.finish();
  return read_lights(path, mm_per_unit, camera_mm, options);
}

void expect_strengths_of_all_or_none(const std::vector<Light>& lights, const JsonReader& json) {
  const auto is_known = [](const Light& light) { return light.is_intensity_known; };
  if (!std::any_of(lights.begin(), lights.end(), is_known)) return;
  const auto unknown = std::find_if_not(lights.begin(), lights.end(), is_known);
  if (unknown != lights.end())
    json.fail("an `intensity` of light " + std::to_string(unknown - lights.begin()) +
              " too, as others have one: all or none");
}

bool are_lights_named_otherwise(std::vector<Light>& lights, const std::vector<std::filesystem::path>& photos,
                                const JsonReader& json) {
  std::optional<std::size_t> unnamed;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const std::vector<std::size_t> found = lights_named(lights, photos[i].filename().string());
    if (found.size() > 1)
      json.fail("one light named `" + photos[i].filename().string() + "`; there are " + std::to_string(found.size()));
    if (found.empty() && !unnamed) unnamed = i;
    if (!found.empty()) order.push_back(found.front());
  }
  if (order.empty())
    return std::any_of(lights.begin(), lights.end(), [](const Light& light) { return !light.name.empty(); });
  if (unnamed) {
    json.fail("a light for each photograph, as names of lights are those of photographs; none is named `" +
              photos[*unnamed].filename().string() + "`");
  }
  std::vector<Light> ordered;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (std::count(order.begin(), order.end(), order[i]) > 1)
      json.fail("a light of its own for `" + photos[i].filename().string() + "`; `" + lights[order[i]].name +
                "` is another photograph's too");
    ordered.push_back(lights[order[i]]);
  }
  lights = std::move(ordered);
  return false;
}

Json json_of(const std::vector<Light>& lights) {
  Json array = Json::array();
  const auto triple = [](const Vec3& v) { return Json{v.x(), v.y(), v.z()}; };
  for (const Light& light : lights) {
    Json entry;
    if (!light.name.empty()) entry["name"] = light.name;
    if (light.kind == Light::Kind::Near) entry["position"] = triple(light.position);
    if (light.kind == Light::Kind::Directional) entry["direction"] = triple(light.direction);
    if (light.is_intensity_known) entry["intensity"] = triple(light.intensity);
    array.push_back(std::move(entry));
  }
  return array;
}

std::string lp_text(const std::vector<Light>& lights, const Camera& camera) {
  std::string text = std::to_string(lights.size()) + "\n";
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (lights[i].kind != Light::Kind::Directional)
      throw InvalidInput("an .lp file holds directions; light " + std::to_string(i + 1) + " is near");
    const Vec3 d = flipped(camera.parameters().rotation * lights[i].direction);
    text += lights[i].name.empty() ? "light" + std::to_string(i + 1) : lights[i].name;
    for (int k = 0; k < 3; ++k) text += " " + number_text(d[k]);
    text += "\n";
  }
  return text;
}

}  // namespace patinate
