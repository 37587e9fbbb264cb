#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/fit/field_job.h"
#include "app/fit/fit_scene.h"
#include "app/fit/scene_pointer.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/simulation/engine.h"
#include "simulation/files/scene_files.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Copies are cheap: they share what was read.
class FieldScene {
 public:
  /// @throws what FitScene does; UsageError for a pointer to anything but /rules/N/rate or /objects/N/initial/MATERIAL;
  /// InvalidInput for a scene of several objects.
  FieldScene(const std::filesystem::path& file, const std::vector<analysis::FitRange>& ranges,
             const RunControl& control);

  [[nodiscard]] const app::FitScene& scene() const { return scene_; }
  /// Where the atlas shows the surface: 0 / 255.
  [[nodiscard]] ImageU8 coverage() const;
  /// Rules' factors and amounts are the maps over their largest value, which becomes the number.
  [[nodiscard]] analysis::AgeWithFields age() const;
  /// Writes `folder / scene.json`, and the maps (EXR, 1 is the number) beside it. @param output  The folder's name in
  /// the end.
  void write(const std::filesystem::path& folder, const std::filesystem::path& output,
             const std::vector<ImageF>& values) const;

 private:
  struct Placed;
  [[nodiscard]] Placed placed(const std::vector<ImageF>& values) const;

  app::FitScene scene_;
};

namespace fs = std::filesystem;

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

/// Expression that limits the rule; "" for nothing. What is no expression becomes a map of the scene.
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
      throw app::UsageError(
          "--vary: " + r.name +
          ": only the rate of a rule (/rules/0/rate) and an initial amount (/objects/0/initial/rust) can "
          "differ from place to place");
    const double most = is_initial_amount(parts) ? r.high : 1.0;
    if (!(r.low >= 0.0) || !(most > 0.0)) throw app::UsageError("--vary: " + r.name + ": a field's values are >= 0");
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
      *app::found_at(out.root, pointer) = number_text(numbers[i]) + " * " + name;
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

std::string field_figure(const Json& v) {
  return v.is_null() ? std::string("undefined") : short_number_text(rounded(v.get<double>(), 4));
}

/// "12.1 to 7.4 Delta E by place (62 % of its square)".
std::string change_text(const Json& report, const char* frames, const char* explained) {
  const Json& share = report.at(explained);
  return field_figure(report.at("single").at(frames).at("by_place")) + " to " +
         field_figure(report.at("after").at(frames).at("by_place")) + " Delta E by place" +
         (share.is_null() ? ""
                          : " (" + short_number_text(rounded(100.0 * share.get<double>(), 3)) +
                                " % of the squared error explained)");
}

/// States what was found, a line each.
void tell_field(CommandRun& run, const Json& report) {
  run.note("fitted frames, error with the best single numbers, then with fields: " +
           change_text(report, "seen", "explained_seen"));
  if (!report.at("after").at("held_out").is_null())
    run.note("held-out frames: " + change_text(report, "held_out", "explained_held_out") + "; their colors " +
             field_figure(report.at("single").at("held_out").at("color_distribution")) + " to " +
             field_figure(report.at("after").at("held_out").at("color_distribution")) +
             "; holding the last fitted frame: " + field_figure(report.at("last_frame")));
  for (const Json& f : report.at("fields"))
    run.note(f.at("name").get<std::string>() + ": " + field_figure(f.at("low")) + " to " + field_figure(f.at("high")) +
             (f.at("unit") == "" ? "" : " " + f.at("unit").get<std::string>()) + "; " +
             std::to_string(f.at("coefficients").size()) + " parameters, of which the data determine " +
             short_number_text(rounded(f.at("effective_numbers").get<double>(), 3)));
}

}  // namespace

int cmd_field(CommandRun& run) {
  analysis::FieldTask task;
  fs::path scene_file, output;
  std::vector<std::string> vary;
  run.line.positional("SCENE", "A scene file with one object", scene_file);
  run.line.positional("HISTORY", "History to fit, place by place: a history, or a transfer", task.history);
  run.line.output("FOLDER", "Folder to make: scene.json, fields, report.html, report.json, after", output);
  run.line.repeated("vary", "POINTER=LOW:HIGH[:log]",
                    "The rate of a rule or an initial amount, and between which values it may differ", vary);
  run.line.options(task.options);
  run.line.example(
      "fit field plate.json copper --vary /rules/0/rate=0.01:1:log --places equal --until 300 -o copper_field");
  if (!run.parse()) return 0;
  if (vary.empty())
    throw app::UsageError(
        "--vary: nothing may vary; give at least one POINTER=LOW:HIGH, such as /rules/0/rate=0.01:1:log");
  std::vector<analysis::FitRange> ranges;
  for (const std::string& text : vary) ranges.push_back(analysis::parse_fit_range(text));
  const std::string word = app::input_word(task.history);
  task.history = app::history_place(task.history);
  const app::PathKind kind = app::kind_of(task.history);
  if (kind != app::PathKind::History && kind != app::PathKind::Transfer)
    throw InvalidInput(task.history.string() + ": is no history or transfer; only those age");
  const FieldScene scene(scene_file, ranges, run.control("scene"));
  run.notes(scene.scene().notes());
  task.parameters = scene.scene().parameters();
  task.outline = scene.scene().outline();
  task.model_name = task.outline.name;
  task.coverage = scene.coverage();
  task.age = scene.age();
  task.write_model = [scene, output](const fs::path& folder, const std::vector<ImageF>& values) {
    scene.write(folder, output, values);
  };
  task.add_inputs = [scene](JobInputs& inputs) { scene.scene().add_inputs(inputs); };
  task.command = "patinate fit field " + app::input_word(scene_file) + " " + word;
  for (const std::string& text : vary) task.command += " --vary " + app::shell_word(text);
  task.command +=
      app::changed_options(option_values(task.options), option_values(analysis::FieldOptions{})) + app::kAnyOutput;
  const std::optional<JobStatus> status = run.make_folder(analysis::plan_field(std::move(task), output), "field");
  if (!status) return 0;
  const Json report = load_json(output / analysis::kFieldReportFile);
  tell_field(run, report);
  run.report_output(*status, output,
                    Json{{"fields", report.at("fields")},
                         {"single", report.at("single")},
                         {"after", report.at("after")},
                         {"explained_seen", report.at("explained_seen")},
                         {"explained_held_out", report.at("explained_held_out")}});
  return 0;
}

}  // namespace patinate::cli
