#include "libcommon/controls/distance_io.h"

#include <array>
#include <cctype>
#include <string>
#include <string_view>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

std::vector<std::vector<Vec3>> read_curves(const std::filesystem::path& path) {
  constexpr std::uint64_t kMaxBytes = 64 << 20;
  constexpr std::size_t kMaxPoints = 100'000;
  const std::string text = read_file(path, kMaxBytes);
  std::vector<std::vector<Vec3>> curves;
  std::string_view rest = text;
  bool is_open = false;
  std::size_t num = 0;
  for (int line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view statement = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (!statement.empty() && (statement.back() == '\r' || statement.back() == ' ')) statement.remove_suffix(1);
    if (statement.empty()) is_open = false;
    if (statement.empty() || statement.front() == '#') continue;
    const std::vector<std::string> parts = split(statement, ',');
    if (line == 1 && std::isalpha(static_cast<unsigned char>(statement.front())) != 0) continue;
    const auto fail = [&](const std::string& problem) {
      throw IoError(path.string(), "line " + std::to_string(line) + ": " + problem);
    };
    if (parts.size() != 3) fail("found " + std::to_string(parts.size()) + " values; expected x,y,z");
    Vec3 point;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto number = parse_number(parts[i]);
      if (!number) fail("`" + parts[i] + "` is not a finite number");
      point[static_cast<Eigen::Index>(i)] = *number;
    }
    if (++num > kMaxPoints) fail("more than " + std::to_string(kMaxPoints) + " points");
    if (!is_open) curves.emplace_back();
    is_open = true;
    curves.back().push_back(point);
  }
  if (curves.empty()) throw IoError(path.string(), "holds no point; expected lines of x,y,z");
  return curves;
}

}  // namespace patinate
