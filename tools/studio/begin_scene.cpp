#include "tools/studio/begin_scene.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate::studio {

// Embedded from begin/*.json.in.
extern const std::string_view kBeginRain, kBeginRust, kBeginMoss, kBeginPatina, kBeginPeeling;

namespace {

constexpr double kGravity_mm_s2 = 9810.0;
constexpr int kLengthDigits = 3;  ///< Of lengths: a person reads them.

std::string length_text(double value) { return number_text(rounded(value, kLengthDigits)); }

/// A direction, written for +y up.
std::string vector_text(std::string_view list, bool is_z_up) {
  std::vector<std::string> v;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    v.emplace_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  if (is_z_up) {
    if (v[2] != "0") v[2] = v[2].front() == '-' ? v[2].substr(1) : "-" + v[2];
    std::swap(v[1], v[2]);
  }
  return "[" + v[0] + ", " + v[1] + ", " + v[2] + "]";
}

/// Number behind the ':' of a word.
double factor_of(std::string_view argument) { return parse_number(std::string(argument)).value_or(1.0); }

}  // namespace

const std::array<BeginPreset, 5>& begin_presets() {
  static const std::array<BeginPreset, 5> presets{
      BeginPreset{"rain_and_dirt", "Rain and dirt",
                  "Dust settles on what is level; rain carries it over edges and leaves it in runs.", kBeginRain},
      BeginPreset{"rust", "Rust that bleeds",
                  "Painted iron rusts in crevices and patches; rain draws orange runs below them.", kBeginRust},
      BeginPreset{"moss", "Moss on the shaded side", "Stone greens where it stays damp and the sun does not come.",
                  kBeginMoss},
      BeginPreset{"patina", "Patina on copper", "Copper browns, and turns green where rain runs and stays.",
                  kBeginPatina},
      BeginPreset{"peeling_paint", "Peeling paint",
                  "Old paint wears thin on ridges; rust creeps below it, and it falls off with its primer.",
                  kBeginPeeling}};
  return presets;
}

std::string begin_scene_text(const std::string& object, const std::string& mesh, double size,
                             const BeginOptions& options) {
  const auto& presets = begin_presets();
  const auto preset =
      std::find_if(presets.begin(), presets.end(), [&](const BeginPreset& p) { return p.name == options.preset; });
  if (preset == presets.end())
    throw InvalidInput("/preset: found \"" + options.preset +
                       "\"; expected rain_and_dirt, rust, moss, patina or peeling_paint");
  const std::optional<double> mm_per_unit = find_mm_per_unit(options.unit);
  if (!mm_per_unit) throw InvalidInput("/unit: found \"" + options.unit + "\"; expected um, mm, cm or m");
  const auto value_of = [&](std::string_view word) {
    const std::size_t colon = std::min(word.find(':'), word.size());
    const std::string_view name = word.substr(0, colon), argument = word.substr(std::min(colon + 1, word.size()));
    if (name == "UNIT") return Json(options.unit).dump();
    if (name == "NAME") return Json(object).dump();
    if (name == "MESH") return Json(mesh).dump();
    if (name == "RESOLUTION") return std::to_string(options.resolution);
    if (name == "MM") return length_text(factor_of(argument) * size * *mm_per_unit);
    // So that drops fly as far, seen from the object: speeds grow with the root of its size.
    if (name == "SPEED")
      return length_text(factor_of(argument) * std::sqrt(kGravity_mm_s2 * size * *mm_per_unit) / *mm_per_unit);
    if (name == "GRAVITY")
      return vector_text("0,-" + length_text(kGravity_mm_s2 / *mm_per_unit) + ",0", options.is_z_up);
    return vector_text(argument, options.is_z_up);
  };
  std::string text;
  for (std::size_t at = 0; at < preset->text.size();) {
    const std::size_t begin = std::min(preset->text.find('<', at), preset->text.size());
    text += preset->text.substr(at, begin - at);
    if (begin == preset->text.size()) break;
    const std::size_t end = preset->text.find('>', begin);
    text += value_of(preset->text.substr(begin + 1, end - begin - 1));
    at = end + 1;
  }
  return text;
}

}  // namespace patinate::studio
