// Header of a Radiance picture [Ward Larson, Shakespeare: Rendering with Radiance, 1998].
#include <cmath>
#include <string>
#include <string_view>

#include "libcommon/core/text.h"
#include "libcommon/image/file_bytes.h"
#include "libcommon/image/file_words.h"

namespace patinate {

namespace {

/// CIE xy of red, green, blue and white; nothing where it is damaged.
std::optional<Chromaticities> radiance_primaries(std::string_view text) {
  std::vector<double> values;
  for (const std::string& word : split(text, ' ')) {
    const auto value = parse_number(word);
    if (!word.empty() && !value) return {};
    if (value) values.push_back(*value);
  }
  if (values.size() != 8) return {};
  Chromaticities primaries;
  for (std::size_t i = 0; i < 4; ++i) primaries.xy[i] = {values[2 * i], values[2 * i + 1]};
  return primaries;
}

void read_radiance_line(std::string_view name, std::string_view value, FileWords& words) {
  if (name == "FORMAT" && value == "32-bit_rle_xyze")
    words.refusal = "is a Radiance picture in CIE XYZ, which is not read; convert it to RGB (ra_xyze -r)";
  if (name == "EXPOSURE") {  // They multiply.
    const double exposure = parse_number(value).value_or(0.0);
    if (exposure > 0.0) words.exposure *= exposure;
    if (!(exposure > 0.0)) words.problems.push_back("its EXPOSURE `" + std::string(value) + "` is no number > 0");
  }
  if (name == "PIXASPECT") {  // Height over width.
    if (std::string problem = pixel_shape_problem(1.0 / parse_number(value).value_or(1.0)); !problem.empty())
      words.problems.push_back(std::move(problem));
  }
  if (name == "COLORCORR") words.problems.emplace_back("its COLORCORR is not used");
  if (name == "PRIMARIES") {
    words.primaries = radiance_primaries(value);
    words.primaries_by = "Radiance PRIMARIES";
    if (!words.primaries) words.problems.emplace_back("its PRIMARIES are damaged and are not used");
  }
}

}  // namespace

void read_radiance_words(const FileBytes& file, FileWords& words) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 16U;
  const std::string_view all = file.text(0, std::min<std::uint64_t>(file.size(), kMost));
  const std::string_view head = all.substr(0, all.find("\n\n"));
  for (std::size_t at = 0; at < head.size();) {
    const std::string_view line = head.substr(at, head.find('\n', at) - at);
    at += line.size() + 1;
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view value = line.substr(equals + 1);
    const std::size_t begin = std::min(value.find_first_not_of(' '), value.size());
    read_radiance_line(line.substr(0, equals), value.substr(begin, value.find_last_not_of(" \r") + 1 - begin), words);
  }
}

}  // namespace patinate
