#include "tools/patinate/study/study_json.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>

#include "libcommon/controls/control_expression.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "tools/patinate/command_line/history_library.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/study/study_cells.h"
#include "tools/patinate/study/study_context.h"
#include "tools/patinate/study/study_fit.h"
#include "tools/patinate/study/study_options.h"
#include "tools/patinate/study/study_ranges.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostStudyLevels = 100'000;
/// Commands that look at what a cell has made.
constexpr std::array<std::string_view, 6> kLooking{"render", "lookup", "export", "evaluate", "compare", "factorize"};
constexpr std::array<std::string_view, 3> kDesigns{"grid", "latin_hypercube", "list"};

/// One level of a factor.
using Level = StudyLevel;
using Factor = std::vector<Level>;

/// Reads a study; what is wrong is collected.
class StudyReader {
 public:
  StudyReader(const fs::path& file, const fs::path& folder, std::vector<std::string>& problems)
      : context_(file, folder, problems), root_(load_json(file)), json_(file.string(), root_) {}

  Study read() {
    json_.expect_format("patinate.study", 1);
    Study study;
    study.name = json_.has("name") ? json_.member("name").string() : context_.file().stem().string();
    if (json_.has("transfer")) study.parts.push_back(read_transfers(json_.member("transfer")));
    if (json_.has("simulate")) study.parts.push_back(read_simulations(json_.member("simulate")));
    if (json_.has("fit")) study.parts.push_back(read_fits(json_.member("fit")));
    if (study.parts.empty())
      context_.problem(context_.file().string() + ": holds neither `transfer` nor `simulate` nor `fit`");
    context_.attempt([&] { json_.finish(); });
    return study;
  }

 private:
  /// "a.obj", "scans/*.obj", or {"path": ..., "name": ..., "options": {...}}.
  void add_input(JsonReader json, std::string_view what, StudyOptions& command, Factor& factor) {
    const JsonReader text = json.is_object() ? json.member("path") : json;
    const fs::path given = text.string();
    std::vector<fs::path> paths{library_place(given)};
    if (paths[0] == given) paths[0] = text.path();
    if (const std::string name = paths[0].filename().string(); name.find('*') != std::string::npos) {
      const fs::path parent = folder_of(paths[0]);
      std::error_code error;
      if (!fs::is_directory(parent, error))
        return context_.problem(text, "`" + text.string() + "`: there is no folder " + parent.string());
      paths = list_files(parent, name);
      for (fs::path& path : paths) path = parent / path.filename();
      if (paths.empty()) context_.problem(text, "no file matches `" + text.string() + "`");
    }
    std::vector<std::string> options;
    std::optional<std::string> name;
    if (json.is_object()) {
      if (json.has("name")) name = json.member("name").string();
      if (json.has("options")) {
        const std::size_t num_before = context_.num_problems();
        options = command.all_words(json.member("options"));
        if (context_.num_problems() == num_before) command.check_together(json.member("options"), options, "made");
      }
      json.finish();
    }
    for (const fs::path& path : paths) {
      context_.check_place(text, path);
      const fs::path plain = path.has_filename() ? path : path.parent_path();
      const std::string stem = fs::is_directory(plain) ? plain.filename().string() : plain.stem().string();
      Level level{.name = slug(name.value_or(stem)), .shown = {{std::string(what), name.value_or(stem)}}};
      level.file = path;
      level.words = {context_.word_of(path)};
      level.words.insert(level.words.end(), options.begin(), options.end());
      factor.push_back(std::move(level));
    }
  }

  Factor read_inputs(JsonReader& part, const char* member, std::string_view what, StudyOptions& command) {
    Factor factor;
    const JsonReader list = part.member(member);
    for (const JsonReader& element : list.elements(kMostStudyLevels))
      context_.attempt([&] { add_input(element, what, command, factor); });
    if (factor.empty()) context_.problem(list, "expected at least one");
    return factor;
  }

  /// A typo is said before anything runs; maps are files beside the study's, for commands in its folder.
  void check_control(const JsonReader& json, std::string& text) {
    try {
      const ControlExpression expression(transfer::parse_control_spec(text).destination, control_kind_names());
      for (const ControlName& name : expression.names()) {
        if (!name.is_file) continue;
        const fs::path path = context_.file().parent_path() / name.text;
        context_.check_place(json, path);
        text.replace(text.find(name.text), name.text.size(), context_.word_of(path));
      }
    } catch (const ParseError& e) {
      context_.problem(json, e.what());
    }
  }

  /// "progress=accessibility", ["...", "..."] together, or {"control": ..., "name": ...}.
  Factor read_controls(JsonReader& part) {
    Factor factor;
    const JsonReader list = part.member("controls");
    for (JsonReader element : list.elements(kMostStudyLevels)) {
      context_.attempt([&] {
        JsonReader control = element.is_object() ? element.member("control") : element;
        std::vector<std::string> texts;
        if (control.is_array()) {
          for (const JsonReader& text : control.elements(100)) texts.push_back(text.string());
        } else {
          texts.push_back(control.string());
        }
        std::string all;
        for (const std::string& text : texts) all += (all.empty() ? "" : " + ") + text;
        if (texts.empty()) control.fail("at least one control");
        for (std::string& text : texts) check_control(control, text);
        const std::string name = element.is_object() && element.has("name") ? element.member("name").string() : all;
        if (element.is_object()) element.finish();
        Level level{.name = slug(name), .shown = {{"control", all}}};
        for (const std::string& text : texts) level.words.insert(level.words.end(), {"--control", text});
        factor.push_back(std::move(level));
      });
    }
    if (factor.empty()) context_.problem(list, "expected at least one");
    return factor;
  }

  void read_step(JsonReader json, StudyPart& part, std::vector<std::vector<std::string>>& step_words) {
    const std::string verb(kLooking[static_cast<std::size_t>(json.member("command").choice(kLooking))]);
    const std::string name = json.has("name") ? json.member("name").string() : verb;
    const bool is_folder = verb == "evaluate" || verb == "compare" || verb == "factorize";
    const std::string file = is_folder && !json.has("file") ? name : json.member("file").string();
    if (!is_file_name(file)) json.member("file").fail("a name of " + file_name_text());
    if (slug(name) != name || name.find('.') != std::string::npos) json.member("name").fail("letters, digits and `_`");
    std::vector<std::string> words;
    if (verb == "compare") {
      const JsonReader with = json.member("with");
      context_.check_place(with, with.path());
      words.push_back(context_.word_of(with.path()));
    }
    const std::size_t num_before = context_.num_problems();
    try {
      if (is_folder) require_no_file_name(file);
    } catch (const UsageError& e) {
      context_.problem(json, e.what());
    }
    StudyOptions command(context_, verb);
    std::vector<std::string> options;
    if (json.has("options")) options = command.all_words(json.member("options"));
    if (context_.num_problems() == num_before) command.check_together(json, options, file);
    words.insert(words.end(), options.begin(), options.end());
    json.finish();
    for (const StudyStep& other : part.steps) {
      if (other.name == part.name + "_" + name)
        context_.problem(json, "two steps are called `" + name + "`; give them a `name`");
      if (other.file == file) context_.problem(json, "two steps make `" + file + "`");
    }
    part.steps.push_back({part.name + "_" + name, verb, file});
    step_words.push_back(std::move(words));
  }

  void finish_part(JsonReader& json, const std::vector<Factor>& factors, StudyPart& part) {
    std::vector<std::vector<std::string>> step_words;
    if (part.name != "fit" && json.has("outputs")) {
      for (const JsonReader& step : json.member("outputs").elements(1000))
        context_.attempt([&] { read_step(step, part, step_words); });
    }
    context_.attempt([&] { json.finish(); });
    for (const std::string& text : make_cells(factors, step_words, part)) context_.problem(json, text);
  }

  StudyPart read_transfers(JsonReader json) {
    StudyPart part{.name = "transfer", .steps = {{"transfer", "transfer", "transfer"}}, .cells = {}};
    StudyOptions command(context_, "transfer");
    std::vector<Factor> factors;
    for (const auto& [member, what] : {std::pair{"histories", "history"}, std::pair{"meshes", "mesh"}})
      context_.attempt([&, m = member, w = what] { factors.push_back(read_inputs(json, m, w, command)); });
    context_.attempt([&] { factors.push_back(read_controls(json)); });
    context_.attempt([&] { command.read_factors(json, factors); });
    finish_part(json, factors, part);
    const auto is_by_tile = [](const StudyCell& cell) {
      return std::find(cell.words[0].begin(), cell.words[0].end(), "--by-tile") != cell.words[0].end();
    };
    part.steps[0].in_items = !part.cells.empty() && std::all_of(part.cells.begin(), part.cells.end(), is_by_tile);
    return part;
  }

  StudyPart read_simulations(JsonReader json) {
    StudyPart part{.name = "simulate", .steps = {{"simulate", "simulate", "simulation"}}, .cells = {}};
    StudyOptions command(context_, "simulate");
    std::vector<Factor> factors;
    context_.attempt([&] { factors.push_back(read_inputs(json, "scenes", "scene", command)); });
    context_.attempt([&] {
      StudyVariation variation;
      if (json.has("design")) variation.design = static_cast<StudyDesign>(json.member("design").choice(kDesigns));
      if (json.has("samples"))
        variation.num_samples = static_cast<std::size_t>(json.member("samples").integer(between(1, 1e5)));
      if (json.has("design_seed"))
        variation.seed = static_cast<std::uint64_t>(json.member("design_seed").integer(between(0, 9e15)));
      if (!json.has("vary")) return;
      for (const JsonReader& range : json.member("vary").elements(100))
        context_.attempt([&] { variation.parameters.push_back(read_study_range(range)); });
      std::vector<fs::path> scenes;
      if (!factors.empty()) {
        for (const Level& level : factors.front()) scenes.push_back(level.file);
      }
      if (context_.has_problems()) return;  // A scene that is not there has no numbers.
      for (Factor& factor : varied_factors(variation, scenes, json)) factors.push_back(std::move(factor));
    });
    context_.attempt([&] { command.read_factors(json, factors); });
    finish_part(json, factors, part);
    return part;
  }

  StudyPart read_fits(JsonReader json) {
    StudyPart part{.name = "fit", .steps = {{"fit", "fit", "fit", true}}, .cells = {}};
    StudyOptions command(context_, "fit");
    std::vector<Factor> factors;
    FitWords wanted_fit;
    for (const auto& [member, what] : {std::pair{"scenes", "scene"}, std::pair{"histories", "history"}})
      context_.attempt([&, m = member, w = what] { factors.push_back(read_inputs(json, m, w, command)); });
    context_.attempt([&] {
      std::vector<fs::path> scenes;
      if (!factors.empty()) {
        for (const Level& level : factors.front()) scenes.push_back(level.file);
      }
      wanted_fit = read_fit_words(json, scenes, context_);
      Level wanted{.name = "", .shown = {}};
      wanted.words = wanted_fit.words;
      factors.push_back({std::move(wanted)});
    });
    context_.attempt([&] { command.read_factors(json, factors); });
    finish_part(json, factors, part);
    if (!context_.has_problems()) check_fit_budgets(json, wanted_fit, part.cells, context_);
    return part;
  }

  StudyContext context_;
  Json root_;
  JsonReader json_;
};

}  // namespace

Study read_study(const fs::path& file, const fs::path& folder, std::vector<std::string>& problems) {
  return StudyReader(file, folder, problems).read();
}

}  // namespace patinate::cli
