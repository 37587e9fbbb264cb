#include "tools/patinate/command_line/plan_file.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "libcommon/job/spread_job.h"
#include "patinate/core/error.h"

namespace patinate::cli {

namespace {

constexpr const char* kFormat = "patinate.plan";
constexpr std::size_t kMaxWords = 10000;
constexpr std::size_t kMaxShown = 12;

Json item_json(std::size_t number, const PlannedItem& item) {
  Json outputs = Json::array();
  for (const std::filesystem::path& output : item.outputs) outputs.push_back(output.generic_string());
  return {{"number", number},
          {"name", item.name},
          {"key", item.key},
          {"outputs", outputs},
          {"waits_for", item_ranges_text(item.waits_for)},
          {"weight", item.weight},
          {"inputs", item.inputs},
          {"is_finished", item.is_finished}};
}

}  // namespace

Json plan_json(const std::vector<std::string>& command, const PlannedWork& work) {
  Json inputs = Json::array(), items = Json::array();
  for (const JobDependency& d : work.depends_on) inputs.push_back({{"name", d.name}, {"key", d.key}});
  for (std::size_t i = 0; i < work.items.size(); ++i) items.push_back(item_json(i, work.items[i]));
  Json json{{"format", kFormat},
            {"version", 1},
            {"program", "patinate " PATINATE_VERSION},
            {"command", command},
            {"output", work.output.string()},
            {"key", work.key},
            {"inputs", inputs},
            {"items", items}};
  json["join"] = work.has_join ? Json{{"weight", work.join_weight}} : Json(nullptr);
  json["is_up_to_date"] = work.is_up_to_date;
  return json;
}

std::string plan_text(const PlannedWork& work) {
  const std::vector<std::size_t> left = work.unfinished();
  std::string text = work.output.string() + ": ";
  if (work.is_up_to_date) return text + "up to date";
  text += std::to_string(work.items.size()) + (work.items.size() == 1 ? " item" : " items");
  if (left.size() < work.items.size()) text += ", " + std::to_string(work.items.size() - left.size()) + " finished";
  if (!left.empty()) text += "; left: " + item_ranges_text(left);
  if (work.has_join) text += work.items.empty() ? "; join does all of the work" : "; then join";
  for (std::size_t k = 0; k < left.size() && k < kMaxShown; ++k) {
    const PlannedItem& item = work.items[left[k]];
    text += "\n  " + std::to_string(left[k]) + " " + item.name;
    if (!item.waits_for.empty()) text += ", waits for " + item_ranges_text(item.waits_for);
  }
  if (left.size() > kMaxShown) text += "\n  and " + std::to_string(left.size() - kMaxShown) + " more";
  return text;
}

PlanFile read_plan_file(const std::filesystem::path& file) {
  const Json root = load_json(file);
  JsonReader json(file.string(), root);
  json.expect_format(kFormat, 1);
  const JsonReader program = json.member("program");
  if (program.string() != "patinate " PATINATE_VERSION) {
    throw IoError(file.string(), "was made by " + program.string().substr(0, 40) +
                                     ", this is patinate " PATINATE_VERSION "; make the plan again");
  }
  PlanFile plan;
  for (const JsonReader& word : json.member("command").elements(kMaxWords)) plan.command.push_back(word.string());
  if (plan.command.empty()) json.member("command").fail("a verb and its arguments");
  plan.identity.file = file;
  plan.identity.key = json.member("key").string();
  for (JsonReader& input : json.member("inputs").elements())
    plan.identity.depends_on.push_back({input.member("name").string(), input.member("key").string()});
  return plan;
}

}  // namespace patinate::cli
