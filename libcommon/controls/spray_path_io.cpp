#include "libcommon/controls/spray_path_io.h"

#include <cctype>
#include <string>
#include <string_view>

#include "libcommon/core/error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace {

constexpr std::uint64_t kMaxBytes = 64 << 20;
constexpr std::size_t kMaxStops = 100'000;

bool is_header(const std::string& first_part) {
  return !first_part.empty() && std::isalpha(static_cast<unsigned char>(first_part.front())) != 0 &&
         first_part != "nan" && first_part != "inf";
}

}  // namespace

std::vector<SprayStop> read_spray_path(const std::filesystem::path& path, const Vec3& default_aim_mm) {
  const std::string text = read_file(path, kMaxBytes);
  std::vector<SprayStop> stops;
  std::string_view rest = text;
  for (int line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view statement = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (!statement.empty() && (statement.back() == '\r' || statement.back() == ' ')) statement.remove_suffix(1);
    if (statement.empty() || statement.front() == '#') continue;
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
