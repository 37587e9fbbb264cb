#include "tools/patinate/study/study_json.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
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
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/study/study_cells.h"
#include "tools/patinate/study/study_ranges.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostLevels = 100'000;
/// Commands that look at what a cell has made.
constexpr std::array<std::string_view, 6> kLooking{"render", "lookup", "export", "evaluate", "compare", "factorize"};
constexpr std::array<std::string_view, 3> kDesigns{"grid", "latin_hypercube", "list"};

/// One level of a factor.
using Level = StudyLevel;
using Factor = std::vector<Level>;

/// What of a text may stand in the name of a cell.
std::string slug(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool is_kept = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '_';
    if (is_kept)
      out += c;
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (!out.empty() && (out.back() == '_' || out.back() == '.')) out.pop_back();
  const std::size_t begin = out.find_first_not_of('.');
  return begin == std::string::npos ? "x" : out.substr(begin);
}

const Verb& verb_named(std::string_view name) {
  const std::span<const Verb> all = verbs();
  return *std::find_if(all.begin(), all.end(), [&](const Verb& v) { return v.name == name; });
}

/// Reads a study; what is wrong is collected.
class StudyReader {
 public:
  StudyReader(const fs::path& file, const fs::path& folder, std::vector<std::string>& problems)
      : file_(file),
        given_folder_(folder),
        folder_(fs::weakly_canonical(fs::absolute(folder))),
        problems_(problems),
        root_(load_json(file)),
        json_(file.string(), root_) {}

  Study read() {
    json_.expect_format("patinate.study", 1);
    Study study;
    study.name = json_.has("name") ? json_.member("name").string() : file_.stem().string();
    const bool has_transfers = json_.has("transfer"), has_simulations = json_.has("simulate");
    if (has_transfers) study.parts.push_back(read_transfers(json_.member("transfer")));
    if (has_simulations) study.parts.push_back(read_simulations(json_.member("simulate")));
    if (study.parts.empty()) problems_.push_back(file_.string() + ": holds neither `transfer` nor `simulate`");
    attempt([&] { json_.finish(); });
    return study;
  }

 private:
  void attempt(const std::function<void()>& work) {
    try {
      work();
    } catch (const InputError& e) {
      problems_.emplace_back(e.what());
    }
  }

  void problem(const JsonReader& json, const std::string& text) {
    problems_.push_back(file_.string() + ": " + json.pointer() + ": " + text);
  }

  /// As commands say it, which run in the study's folder.
  std::string word_of(const fs::path& path) const {
    const fs::path whole = fs::absolute(path).lexically_normal();
    const fs::path named = whole.lexically_relative(fs::absolute(given_folder_).lexically_normal());
    std::error_code error;
    if (fs::equivalent((folder_ / named).lexically_normal(), whole, error)) return named.generic_string();
    return fs::relative(fs::weakly_canonical(whole), folder_).generic_string();  // A link lies between them.
  }

  void check_place(const JsonReader& json, const fs::path& path) {
    try {
      require_exists(path);
    } catch (const InputError& e) {
      return problem(json, e.what());
    }
    const fs::path place = fs::weakly_canonical(fs::absolute(path));
    if (std::mismatch(folder_.begin(), folder_.end(), place.begin(), place.end()).first == folder_.end())
      problem(json, path.string() + " lies in the study's own folder, so that the study would wait for itself");
  }

  /// "a.obj", "scans/*.obj", or {"path": ..., "name": ..., "options": {...}}.
  void add_input(JsonReader json, std::string_view what, const CommandDeclaration& command, Factor& factor) {
    const JsonReader text = json.is_object() ? json.member("path") : json;
    const fs::path given = text.string();
    std::vector<fs::path> paths{library_place(given)};
    if (paths[0] == given) paths[0] = text.path();
    if (const std::string name = paths[0].filename().string(); name.find('*') != std::string::npos) {
      const fs::path parent = folder_of(paths[0]);
      std::error_code error;
      if (!fs::is_directory(parent, error))
        return problem(text, "`" + text.string() + "`: there is no folder " + parent.string());
      paths = list_files(parent, name);
      for (fs::path& path : paths) path = parent / path.filename();
      if (paths.empty()) problem(text, "no file matches `" + text.string() + "`");
    }
    std::vector<std::string> options;
    std::optional<std::string> name;
    if (json.is_object()) {
      if (json.has("name")) name = json.member("name").string();
      if (json.has("options")) {
        JsonReader members = json.member("options");
        for (const std::string& key : members.keys()) {
          for (const std::string& word : option_words(command, key, members.member(key))) options.push_back(word);
        }
      }
      json.finish();
    }
    for (const fs::path& path : paths) {
      check_place(text, path);
      const fs::path plain = path.has_filename() ? path : path.parent_path();
      const std::string stem = fs::is_directory(plain) ? plain.filename().string() : plain.stem().string();
      Level level{.name = slug(name.value_or(stem)), .shown = {{std::string(what), name.value_or(stem)}}};
      level.file = path;
      level.words = {word_of(path)};
      level.words.insert(level.words.end(), options.begin(), options.end());
      factor.push_back(std::move(level));
    }
  }

  Factor read_inputs(JsonReader& part, const char* member, std::string_view what, const CommandDeclaration& command) {
    Factor factor;
    const JsonReader list = part.member(member);
    for (const JsonReader& element : list.elements(kMostLevels))
      attempt([&] { add_input(element, what, command, factor); });
    if (factor.empty()) problem(list, "expected at least one");
    return factor;
  }

  /// The words that give one value to an option.
  std::vector<std::string> option_words(const CommandDeclaration& command, const std::string& key,
                                        const JsonReader& value) {
    std::string wanted = key;
    std::replace(wanted.begin(), wanted.end(), '-', '_');
    std::vector<std::string> names;
    for (const ArgumentInfo& a : command.arguments) {
      if (a.is_positional() || a.is_common || a.name == "-o" || a.key() == "control") continue;
      names.push_back(a.key());
      if (a.key() != wanted) continue;
      if (a.kind == ArgumentKind::Flag) {
        if (value.boolean()) return {a.name};
        return a.has_no_form ? std::vector<std::string>{"--no-" + a.name.substr(2)} : std::vector<std::string>{};
      }
      const std::string text = value.is_string() ? value.string() : number_text(value.number());
      try {
        check_options(verb_named(command.verb), {a.name, text});
      } catch (const UsageError& e) {
        problem(value, e.what());
      }
      if (a.type != ValueType::Path && a.type != ValueType::Text) return {a.name, text};
      const fs::path path = file_.parent_path() / text;  // Files are relative to the study's file, as elsewhere in it.
      return {a.name, fs::exists(path) ? word_of(path) : text};
    }
    problem(value, "`" + std::string(command.verb) + "` has no option `" + key + "`" + did_you_mean(wanted, names));
    return {};
  }

  /// Options; those with a list of values are factors.
  void read_options(JsonReader& part, const CommandDeclaration& command, std::vector<Factor>& factors) {
    if (part.has("options")) {
      JsonReader options = part.member("options");
      for (const std::string& key : options.keys()) {
        attempt([&] {
          const JsonReader value = options.member(key);
          Factor factor;
          if (!value.is_array()) {
            factor.push_back({.name = "", .shown = {}});
            factor.back().words = option_words(command, key, value);
          } else {
            for (const JsonReader& v : value.elements(kMostLevels)) {
              const std::string text = v.is_string() ? v.string() : number_text(v.number());
              factor.push_back({.name = slug(key + text), .shown = {{key, text}}});
              factor.back().words = option_words(command, key, v);
            }
            if (factor.empty()) problem(value, "expected at least one value");
          }
          factors.push_back(std::move(factor));
        });
      }
    }
    if (!part.has("seeds")) return;
    Factor seeds;
    const JsonReader list = part.member("seeds");
    for (const JsonReader& seed : list.elements(kMostLevels)) {
      attempt([&] {
        const std::string text = std::to_string(seed.integer(between(0, 9e15)));
        seeds.push_back({.name = "seed" + text, .shown = {{"seed", text}}});
        seeds.back().words = {"--seed", text};
      });
    }
    if (seeds.empty()) problem(list, "expected at least one");
    factors.push_back(std::move(seeds));
  }

  /// A typo is said before anything runs; maps are files beside the study's, for commands in its folder.
  void check_control(const JsonReader& json, std::string& text) {
    try {
      const ControlExpression expression(transfer::parse_control_spec(text).destination, control_kind_names());
      for (const ControlName& name : expression.names()) {
        if (!name.is_file) continue;
        const fs::path path = file_.parent_path() / name.text;
        check_place(json, path);
        text.replace(text.find(name.text), name.text.size(), word_of(path));
      }
    } catch (const ParseError& e) {
      problem(json, e.what());
    }
  }

  /// "progress=accessibility", ["...", "..."] together, or {"control": ..., "name": ...}.
  Factor read_controls(JsonReader& part) {
    Factor factor;
    const JsonReader list = part.member("controls");
    for (JsonReader element : list.elements(kMostLevels)) {
      attempt([&] {
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
    if (factor.empty()) problem(list, "expected at least one");
    return factor;
  }

  void read_step(JsonReader json, StudyPart& part, std::vector<std::vector<std::string>>& step_words) {
    const std::string_view verb = kLooking[static_cast<std::size_t>(json.member("command").choice(kLooking))];
    const CommandDeclaration command = declaration_of(verb_named(verb));
    const std::string name = json.has("name") ? json.member("name").string() : std::string(verb);
    const bool is_folder = verb == "evaluate" || verb == "compare" || verb == "factorize";
    const std::string file = is_folder && !json.has("file") ? name : json.member("file").string();
    if (!is_file_name(file)) json.member("file").fail("a name of " + file_name_text());
    if (slug(name) != name || name.find('.') != std::string::npos) json.member("name").fail("letters, digits and `_`");
    std::vector<std::string> words;
    if (verb == "compare") {
      const JsonReader with = json.member("with");
      check_place(with, with.path());
      words.push_back(word_of(with.path()));
    }
    if (json.has("options")) {
      JsonReader options = json.member("options");
      for (const std::string& key : options.keys()) {
        attempt([&] {
          for (const std::string& word : option_words(command, key, options.member(key))) words.push_back(word);
        });
      }
    }
    json.finish();
    for (const StudyStep& other : part.steps) {
      if (other.name == part.name + "_" + name)
        problem(json, "two steps are called `" + name + "`; give them a `name`");
      if (other.file == file) problem(json, "two steps make `" + file + "`");
    }
    part.steps.push_back({part.name + "_" + name, std::string(verb), file});
    step_words.push_back(std::move(words));
  }

  void finish_part(JsonReader& json, const std::vector<Factor>& factors, StudyPart& part) {
    std::vector<std::vector<std::string>> step_words;
    if (json.has("outputs")) {
      for (const JsonReader& step : json.member("outputs").elements(1000))
        attempt([&] { read_step(step, part, step_words); });
    }
    attempt([&] { json.finish(); });
    for (const std::string& text : make_cells(factors, step_words, part)) problem(json, text);
  }

  StudyPart read_transfers(JsonReader json) {
    StudyPart part{.name = "transfer", .steps = {{"transfer", "transfer", "transfer"}}, .cells = {}};
    const CommandDeclaration command = declaration_of(verb_named("transfer"));
    std::vector<Factor> factors;
    for (const auto& [member, what] : {std::pair{"histories", "history"}, std::pair{"meshes", "mesh"}})
      attempt([&, m = member, w = what] { factors.push_back(read_inputs(json, m, w, command)); });
    attempt([&] { factors.push_back(read_controls(json)); });
    attempt([&] { read_options(json, command, factors); });
    finish_part(json, factors, part);
    return part;
  }

  StudyPart read_simulations(JsonReader json) {
    StudyPart part{.name = "simulate", .steps = {{"simulate", "simulate", "simulation"}}, .cells = {}};
    const CommandDeclaration command = declaration_of(verb_named("simulate"));
    std::vector<Factor> factors;
    attempt([&] { factors.push_back(read_inputs(json, "scenes", "scene", command)); });
    attempt([&] {
      StudyVariation variation;
      if (json.has("design")) variation.design = static_cast<StudyDesign>(json.member("design").choice(kDesigns));
      if (json.has("samples"))
        variation.num_samples = static_cast<std::size_t>(json.member("samples").integer(between(1, 1e5)));
      if (json.has("design_seed"))
        variation.seed = static_cast<std::uint64_t>(json.member("design_seed").integer(between(0, 9e15)));
      if (!json.has("vary")) return;
      for (const JsonReader& range : json.member("vary").elements(100))
        attempt([&] { variation.parameters.push_back(read_study_range(range)); });
      std::vector<fs::path> scenes;
      if (!factors.empty()) {
        for (const Level& level : factors.front()) scenes.push_back(level.file);
      }
      if (!problems_.empty()) return;  // A scene that is not there has no numbers.
      for (Factor& factor : varied_factors(variation, scenes, json)) factors.push_back(std::move(factor));
    });
    attempt([&] { read_options(json, command, factors); });
    finish_part(json, factors, part);
    return part;
  }

  fs::path file_, given_folder_;
  fs::path folder_;  ///< The same, without links.
  std::vector<std::string>& problems_;
  Json root_;
  JsonReader json_;
};

}  // namespace

Study read_study(const fs::path& file, const fs::path& folder, std::vector<std::string>& problems) {
  return StudyReader(file, folder, problems).read();
}

}  // namespace patinate::cli
