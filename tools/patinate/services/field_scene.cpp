#include "tools/patinate/services/field_scene.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/simulation/engine.h"
#include "simulation/files/scene_files.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/services/scene_pointer.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// "/rules/2/rate" as {"rules", "2", "rate"}.
std::vector<std::string> parts_of(const std::string& pointer) { return split(pointer.substr(1), '/'); }

bool is_rule_rate(const std::vector<std::string>& parts) {
  return parts.size() == 3 && parts[0] == "rules" && (parts[2] == "rate" || parts[2] == "alpha");
}
bool is_initial_amount(const std::vector<std::string>& parts) {
  return parts.size() == 4 && parts[0] == "objects" && parts[2] == "initial";
}

/// A name that no map of the scene has.
std::string free_map_name(const Json& root, const std::string& stem) {
  int number = 1;
  while (root.contains("maps") && root["maps"].contains(stem + "_" + std::to_string(number))) ++number;
  return stem + "_" + std::to_string(number);
}

/// What limits the rule as an expression; "" for nothing. What is no expression becomes a map of the scene.
std::string where_of(Json& root, const Json& rule, const std::string& read) {
  if (!rule.contains("where") || rule["where"].is_string()) return read;
  const std::string name = free_map_name(root, "where");
  root["maps"][name] =
      rule["where"].is_array() ? Json{{"kind", "objects"}, {"objects", rule["where"]}} : Json(rule["where"]);
  return name;
}

/// Largest value of a map, and what each place has of it.
std::pair<double, ImageF> shares_of(const ImageF& values) {
  float most = 0.0F;
  for (const float v : values.values()) most = std::max(most, v);
  ImageF shares = values;
  for (float& v : shares.values()) v = most > 0.0F ? v / most : 0.0F;
  return {static_cast<double>(most), std::move(shares)};
}

}  // namespace

/// A scene file with maps that are to have these pictures.
struct FieldScene::Placed {
  Json root;
  std::vector<std::string> maps;  ///< Names, "" where the number is one everywhere.
  std::vector<ImageF> pictures;   ///< In [0, 1].
};

FieldScene::FieldScene(const fs::path& file, const std::vector<analysis::FitRange>& ranges, const RunControl& control)
    : scene_(file, ranges, {}, control) {
  for (const analysis::FitRange& r : ranges) {
    const std::vector<std::string> parts = parts_of(r.name);
    if (!is_rule_rate(parts) && !is_initial_amount(parts))
      throw UsageError("--vary: " + r.name +
                       ": only the rate of a rule (/rules/0/rate) and an initial amount (/objects/0/initial/rust) can "
                       "differ from place to place");
    const double most = is_initial_amount(parts) ? r.high : 1.0;
    if (!(r.low >= 0.0) || !(most > 0.0)) throw UsageError("--vary: " + r.name + ": a field's values are >= 0");
  }
  if (scene_.base().scene.objects.size() != 1)
    throw InvalidInput(file.string() + ": has " + std::to_string(scene_.base().scene.objects.size()) +
                       " objects; a field is of a scene with one");
}

ImageU8 FieldScene::coverage() const { return simulation::Simulation(scene_.base().scene).coverage(); }

FieldScene::Placed FieldScene::placed(const std::vector<ImageF>& values) const {
  std::vector<double> numbers;
  std::vector<ImageF> shares;
  for (const ImageF& v : values) {
    auto [most, share] = shares_of(v);
    numbers.push_back(most);
    shares.push_back(std::move(share));
  }
  Placed out{.root = scene_.with(numbers), .maps = {}, .pictures = {}};
  for (std::size_t i = 0; i < values.size(); ++i) {
    out.maps.emplace_back();
    out.pictures.push_back(std::move(shares[i]));
    if (values[i].num_pixels() == 1) continue;
    const std::string& pointer = scene_.parameters()[i].range.name;
    const std::vector<std::string> parts = parts_of(pointer);
    const std::string name = free_map_name(out.root, "field");
    if (is_rule_rate(parts)) {
      Json& rule = out.root["rules"][std::stoul(parts[1])];
      const std::string where = where_of(out.root, rule, scene_.base().scene.rules[std::stoul(parts[1])].where);
      rule["where"] = where.empty() ? name : "(" + where + ") * " + name;
    } else {
      *found_at(out.root, pointer) = number_text(numbers[i]) + " * " + name;
    }
    out.root["maps"][name] = {{"kind", "noise"}};  // Until its picture is there.
    out.maps.back() = name;
  }
  return out;
}

analysis::AgeWithFields FieldScene::age() const {
  return [scene = *this](const std::vector<ImageF>& values, const RunControl& control) -> analysis::AgedSurface {
    const Placed placed = scene.placed(values);
    return scene.scene_.aged(placed.root, control, [&](simulation::Scene& read) {
      for (simulation::SceneMap& map : read.maps) {
        const auto found = std::find(placed.maps.begin(), placed.maps.end(), map.name);
        if (found == placed.maps.end()) continue;
        map.kind = "image";
        map.images = {placed.pictures[found - placed.maps.begin()]};
      }
    });
  };
}

void FieldScene::write(const fs::path& folder, const fs::path& output, const std::vector<ImageF>& values) const {
  Placed placed = this->placed(values);
  scene_.move_paths(placed.root, output);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string& name = placed.maps[i];
    if (name.empty()) continue;
    const fs::path picture = fs::path(analysis::kFieldFolder) / (name + ".exr");
    fs::create_directories(folder / analysis::kFieldFolder);
    double most = 0.0;
    for (const float v : values[i].values()) most = std::max(most, static_cast<double>(v));
    write_scaled_exr(folder / picture, placed.pictures[i],
                     {.low = 0.0, .high = most, .unit = scene_.parameters()[i].unit});
    placed.root["maps"][name] = {{"kind", "image"}, {"image", picture.generic_string()}};
  }
  save_json(folder / "scene.json", placed.root);
}

}  // namespace patinate::cli
