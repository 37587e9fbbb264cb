#include "libcommon/controls/spray_path_io.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace {

constexpr std::uint64_t kMaxPathBytes = 64 << 20;
constexpr std::size_t kMaxStops = 100'000;
constexpr Range kSpread{.low = 0, .high = 90, .is_low_open = true};

bool is_header(const std::string& first_part) {
  return !first_part.empty() && std::isalpha(static_cast<unsigned char>(first_part.front())) != 0 &&
         first_part != "nan" && first_part != "inf";
}

/// The lines of a text that say something, with their numbers, without blanks at the end.
std::vector<std::pair<int, std::string_view>> statements(std::string_view rest) {
  std::vector<std::pair<int, std::string_view>> lines;
  for (int line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view statement = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (!statement.empty() && (statement.back() == '\r' || statement.back() == ' ')) statement.remove_suffix(1);
    if (!statement.empty() && statement.front() != '#') lines.emplace_back(line, statement);
  }
  return lines;
}

Vec3 aim_along(const Vec3& position, const Vec3& direction, const Vec3& default_aim) {
  const double distance = std::max((default_aim - position).norm(), 1e-6);
  return position + distance * direction.normalized();
}

/// Errors of the strokes themselves name the file.
std::vector<SprayStop> stops_of(const std::filesystem::path& path, const std::vector<SprayStroke>& strokes,
                                const SprayOptions& options) {
  std::size_t num = 0;
  for (const SprayStroke& stroke : strokes) num += stroke.points.size();
  if (num == 0) throw IoError(path.string(), "holds no stroke");
  if (num > kMaxStops) throw IoError(path.string(), "more than " + std::to_string(kMaxStops) + " points");
  try {
    std::vector<SprayStop> stops = stroke_stops(strokes, options);
    if (stops.size() > kMaxStops)
      throw InvalidInput("spray: strokes need more than " + std::to_string(kMaxStops) + " stops");
    return stops;
  } catch (const InvalidInput& e) {
    throw IoError(path.string(), e.what());
  }
}

std::vector<SprayStroke> read_json_strokes(const std::filesystem::path& path, const Vec3& default_aim) {
  const Json json = load_json(path);
  JsonReader root(path.string(), json);
  root.expect_format("patinate.strokes", 1);
  std::vector<SprayStroke> strokes;
  for (JsonReader& element : std::vector<JsonReader>(root.member("strokes").elements(kMaxStops))) {
    SprayStroke stroke;
    std::optional<double> spread;
    if (element.has("name")) (void)element.member("name").string();
    if (element.has("flow")) stroke.flow = element.member("flow").number(at_least(0));
    if (element.has("spread")) spread = element.member("spread").number(kSpread);
    for (JsonReader& p : std::vector<JsonReader>(element.member("points").elements(kMaxStops))) {
      const auto vector = [&](const char* key) {
        const std::vector<double> v = p.member(key).numbers(3);
        return Vec3(v[0], v[1], v[2]);
      };
      SprayStop stop{.position_mm = vector("position"), .aim_mm = default_aim, .spread_deg = spread};
      if (p.has("aim")) stop.aim_mm = vector("aim");
      if (p.has("direction")) stop.aim_mm = aim_along(stop.position_mm, vector("direction"), default_aim);
      if (p.has("dwell")) stop.dwell = p.member("dwell").number(at_least(0));
      if (p.has("spread")) stop.spread_deg = p.member("spread").number(kSpread);
      p.finish();
      stroke.points.push_back(stop);
    }
    element.finish();
    strokes.push_back(std::move(stroke));
  }
  root.finish();
  return strokes;
}

/// Strokes from lines below a line of column names.
std::vector<SprayStroke> read_csv_strokes(const std::filesystem::path& path, const std::string& text,
                                          const Vec3& default_aim) {
  static const std::vector<std::string> known{"stroke", "x",     "y",           "z",           "aim_x",
                                              "aim_y",  "aim_z", "direction_x", "direction_y", "direction_z",
                                              "spread", "flow",  "dwell"};
  const auto lines = statements(text);
  const std::vector<std::string> names = split(lines.front().second, ',');
  const auto fail = [&](int line, const std::string& problem) {
    throw IoError(path.string(), "line " + std::to_string(line) + ": " + problem);
  };
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      fail(lines.front().first, "unknown column `" + name + "`" + did_you_mean(name, known));
    }
  }
  std::vector<SprayStroke> strokes;
  std::string current;
  for (std::size_t n = 1; n < lines.size(); ++n) {
    const int line = lines[n].first;
    const std::vector<std::string> parts = split(lines[n].second, ',');
    if (parts.size() != names.size()) {
      fail(line, "found " + std::to_string(parts.size()) + " values; expected " + std::to_string(names.size()));
    }
    const auto text_of = [&](std::string_view column) -> std::string {
      const auto at = std::find(names.begin(), names.end(), column);
      return at == names.end() ? "" : parts[at - names.begin()];
    };
    const auto number = [&](const std::string& column) -> std::optional<double> {
      const std::string word = text_of(column);
      const auto value = parse_number(word);
      if (!word.empty() && !value) fail(line, column + ": `" + word + "` is not a finite number");
      return value;
    };
    const auto vector = [&](const std::string& prefix) -> std::optional<Vec3> {
      const auto x = number(prefix + "x"), y = number(prefix + "y"), z = number(prefix + "z");
      if (!x && !y && !z) return std::nullopt;
      if (!x || !y || !z) fail(line, prefix + "x, " + prefix + "y and " + prefix + "z: all three are needed");
      return Vec3(*x, *y, *z);
    };
    const auto position = vector("");
    if (!position) fail(line, "x, y and z are needed");
    SprayStop stop{
        .position_mm = *position, .aim_mm = vector("aim_").value_or(default_aim), .spread_deg = number("spread")};
    if (const auto direction = vector("direction_")) stop.aim_mm = aim_along(*position, *direction, default_aim);
    stop.dwell = number("dwell").value_or(1.0);
    if (!(stop.dwell >= 0.0)) fail(line, "the dwell is negative; use >= 0");
    if (stop.spread_deg && !kSpread.contains(*stop.spread_deg)) fail(line, "the spread is outside (0, 90] deg");
    const std::string stroke = text_of("stroke");
    if (strokes.empty() || stroke != current) {
      strokes.push_back({{}, number("flow").value_or(1.0)});
      current = stroke;
    }
    strokes.back().points.push_back(stop);
  }
  return strokes;
}

bool names_strokes(std::string_view text) {
  const auto lines = statements(text);
  if (lines.empty()) return false;
  const std::vector<std::string> names = split(lines.front().second, ',');
  return std::find(names.begin(), names.end(), "stroke") != names.end();
}

}  // namespace

std::vector<SprayStop> read_spray_path(const std::filesystem::path& path, const Vec3& default_aim_mm,
                                       const SprayOptions& options) {
  if (path.extension() == ".json") return stops_of(path, read_json_strokes(path, default_aim_mm), options);
  const std::string text = read_file(path, kMaxPathBytes);
  if (names_strokes(text)) return stops_of(path, read_csv_strokes(path, text, default_aim_mm), options);
  std::vector<SprayStop> stops;
  for (const auto& [number_of_line, statement] : statements(text)) {
    const int line = number_of_line;
    const auto fail = [&](const std::string& problem) {
      throw IoError(path.string(), "line " + std::to_string(line) + ": " + problem);
    };
    const std::vector<std::string> parts = split(statement, ',');
    if (line == 1 && is_header(parts[0])) continue;
    if (parts.size() != 3 && parts.size() != 4 && parts.size() != 7) {
      fail("found " + std::to_string(parts.size()) + " values; expected x,y,z[,dwell[,aim_x,aim_y,aim_z]]");
    }
    std::array<double, 7> v{0, 0, 0, 1, default_aim_mm.x(), default_aim_mm.y(), default_aim_mm.z()};
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto number = parse_number(parts[i]);
      if (!number) fail("`" + parts[i] + "` is not a finite number");
      v[i] = *number;
    }
    const SprayStop stop{.position_mm = {v[0], v[1], v[2]}, .dwell = v[3], .aim_mm = {v[4], v[5], v[6]}};
    if (!(stop.dwell >= 0.0)) fail("the dwell is negative; use >= 0");
    if (stop.aim_mm == stop.position_mm) fail("the nozzle aims at its own position");
    if (stops.size() == kMaxStops) fail("more than " + std::to_string(kMaxStops) + " stops");
    stops.push_back(stop);
  }
  if (stops.empty()) throw IoError(path.string(), "holds no stop; expected lines of x,y,z[,dwell[,aim_x,aim_y,aim_z]]");
  return stops;
}

}  // namespace patinate
