#include "libcommon/history/appearance_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/hash.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/color.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxPoints = 100'000;
constexpr std::size_t kMaxMaterials = 64;
constexpr const char* kAnything =
    "a number in [0, 1], [[time, value], ...], {\"control\": ..., \"values\": [[control, value], ...]} or {\"mask\": "
    "...}";

/// [[x, value], ...]
ValueCurve read_curve(const JsonReader& json) {
  ValueCurve curve;
  for (const JsonReader& point : json.elements(kMaxPoints)) {
    const std::vector<double> pair = point.numbers(2);
    if (!curve.points.empty() && !(pair[0] > curve.points.back()[0])) point.fail("a number above the one before");
    if (!(pair[1] >= 0.0 && pair[1] <= 1.0)) point.fail("a value in [0, 1]");
    curve.points.push_back({pair[0], pair[1]});
  }
  if (curve.points.empty()) json.fail("one pair or more");
  return curve;
}

StatedValue read_value(JsonReader json) {
  if (json.is_number()) return {.curve = {{{0.0, json.number(between(0, 1))}}}};
  if (json.is_array()) return {.by = StatedValue::By::Time, .curve = read_curve(json)};
  if (!json.is_object()) json.fail(kAnything);
  StatedValue value;
  if (json.has("control")) {
    value.by = StatedValue::By::Control;
    value.control = json.member("control").string();
    value.curve = read_curve(json.member("values"));
  } else if (json.has("mask")) {
    value.by = StatedValue::By::Mask;
    value.mask = json.member("mask").path();
    value.curve = json.has("values") ? read_curve(json.member("values")) : ValueCurve{{{0.0, 0.0}, {1.0, 1.0}}};
  } else {
    json.fail(kAnything);
  }
  json.finish();
  return value;
}

/// "#rrggbb" in sRGB, or three linear numbers.
std::array<double, 3> read_color_of(const JsonReader& json) {
  if (!json.is_string()) {
    const std::vector<double> linear = json.numbers(3, between(0, 1));
    return {linear[0], linear[1], linear[2]};
  }
  const std::string text = json.string();
  constexpr std::size_t kLength = 7;
  if (text.size() != kLength || text[0] != '#' ||
      text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
    json.fail("\"#rrggbb\", or [red, green, blue] in linear light");
  std::array<double, 3> color{};
  for (std::size_t c = 0; c < 3; ++c) {
    const int code = std::stoi(text.substr(1 + 2 * c, 2), nullptr, 16);
    color[c] = static_cast<double>(linear_from_srgb(static_cast<float>(code) / 255.0f));
  }
  return color;
}

StatedMaterial read_material(JsonReader json) {
  StatedMaterial m;
  m.color = read_color_of(json.member("color"));
  m.metalness = json.member("metalness").number(between(0, 1));
  if (json.has("roughness")) m.roughness = json.member("roughness").number(between(0, 1));
  if (json.has("specular")) m.specular = json.member("specular").number(between(0, 1));
  if (json.has("tint")) m.tint = read_color_of(json.member("tint"));
  json.finish();
  return m;
}

Appearance read_members(JsonReader& json) {
  Appearance a;
  if (json.has("materials")) {
    for (const JsonReader& material : json.member("materials").elements(kMaxMaterials))
      a.materials.push_back(read_material(material));
    if (a.materials.empty()) json.member("materials").fail("one material or more");
    if (std::any_of(a.materials.begin(), a.materials.end(), [&](const StatedMaterial& m) {
          return m.roughness.has_value() != a.materials.front().roughness.has_value();
        }))
      json.member("materials").fail("`roughness` of all materials, or of none");
  }
  const auto read = [&](const char* name, std::optional<StatedValue>& into) {
    if (!json.has(name)) return;
    if (!a.materials.empty()) json.member(name).fail("nothing: `materials` say it already");
    into = read_value(json.member(name));
  };
  read("metalness", a.metalness);
  read("roughness", a.roughness);
  read("specular", a.specular);
  if (json.has("tint")) {
    if (!a.materials.empty()) json.member("tint").fail("nothing: `materials` say it already");
    a.tint = read_color_of(json.member("tint"));
  }
  json.finish();
  if (a.is_empty()) json.fail("metalness, roughness, specular, tint or materials");
  return a;
}

void add_value(ContentHash& hash, const char* name, const std::optional<StatedValue>& value) {
  if (!value) return;
  hash.add(name).add(static_cast<std::int64_t>(value->by)).add(value->control);
  if (value->by == StatedValue::By::Mask) hash.add_file(value->mask);
  for (const auto& [x, v] : value->curve.points) hash.add(x).add(v);
}

void add_color(ContentHash& hash, const std::array<double, 3>& color) {
  for (const double c : color) hash.add(c);
}

}  // namespace

Appearance read_appearance(JsonReader json) { return read_members(json); }

Appearance read_appearance_file(const std::filesystem::path& file) {
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  json.expect_format("patinate.appearance", 1);
  return read_members(json);
}

std::string appearance_key(const Appearance& appearance) {
  ContentHash hash;
  hash.add("appearance 1");
  add_value(hash, "metalness", appearance.metalness);
  add_value(hash, "roughness", appearance.roughness);
  add_value(hash, "specular", appearance.specular);
  if (appearance.tint) add_color(hash.add("tint"), *appearance.tint);
  for (const StatedMaterial& m : appearance.materials) {
    add_color(hash.add("material"), m.color);
    hash.add(m.metalness);
    if (m.roughness) hash.add(*m.roughness);
    if (m.roughness || m.specular) hash.add(m.specular.value_or(static_cast<double>(kUnknownSpecular)));
    if (!m.roughness) hash.add(m.specular ? "no roughness" : "no mirror");
    if (m.tint) add_color(hash.add("tint"), *m.tint);
  }
  return hash.hex();
}

}  // namespace patinate
