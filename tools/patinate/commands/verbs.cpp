#include "tools/patinate/command_line/verbs.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "app/request/usage_error.h"
#include "libcommon/core/text.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

/// Groups of the first page of help. Those of the main path are headings.
constexpr const char* kPhotographs = "Photographs become a history";
constexpr const char* kMeshes = "A mesh ages like it";
constexpr const char* kSimulation = "Aging is simulated";
constexpr const char* kResults = "View everything";
constexpr const char* kMeasuring = "measuring";
constexpr const char* kHistories = "histories";
constexpr const char* kControls = "controls";
constexpr const char* kTransfers = "transfers";
constexpr const char* kSimulations = "simulations";
constexpr const char* kMany = "much work";
constexpr const char* kFiles = "files";
constexpr const char* kHelp = "help";

/// How many of the table are of the main path.
constexpr std::size_t kNumMain = 10;

// The ten of the main path first; then the rest by group.
constexpr std::array kVerbs{
    Verb{.name = "init",
         .brief = "Drafts a capture project from a folder of photographs.",
         .run = cmd_init,
         .group = kPhotographs,
         .is_planned = false},
    Verb{.name = "ingest",
         .brief = "Makes a material history of photographs (capture.json).",
         .run = cmd_ingest,
         .group = kPhotographs},
    Verb{.name = "control",
         .brief = "Makes a control map of a mesh, which guides its aging.",
         .run = cmd_control,
         .group = kMeshes},
    Verb{.name = "transfer",
         .brief = "Ages a mesh with a history: source coordinates for every texel.",
         .run = cmd_transfer,
         .group = kMeshes},
    Verb{.name = "texture",
         .brief = "Writes a transfer's texture at any time.",
         .run = cmd_texture,
         .group = kMeshes,
         .formers = {"lookup"}},
    Verb{.name = "render",
         .brief = "Makes a picture of a transfer or simulation at a time, a strip of times, or a movie.",
         .run = cmd_render,
         .group = kMeshes},
    Verb{.name = "export",
         .brief = "Writes a transfer or simulation as GLB, USD or OBJ, or a history too as images or a movie.",
         .run = cmd_export,
         .group = kMeshes},
    Verb{.name = "simulate",
         .brief = "Ages a scene with particles that carry water, dirt, rust.",
         .run = cmd_simulate,
         .group = kSimulation},
    Verb{.name = "fit",
         .brief = "Finds the parameters with which a scene ages like a history.",
         .run = cmd_fit,
         .group = kSimulation},
    Verb{.name = "studio",
         .brief = "Shows histories, transfers and simulations in the browser.",
         .run = cmd_studio,
         .group = kResults,
         .is_planned = false},

    Verb{.name = "unlight",
         .brief = "Makes albedo and normals from photographs under known lights.",
         .run = cmd_unlight,
         .group = kMeasuring},
    Verb{.name = "calibrate",
         .brief = "Calibrates camera and light positions, or the camera response.",
         .run = cmd_calibrate,
         .group = kMeasuring,
         .is_planned = false,
         .kinds = {"camera", "spheres", "lambertian", "response"}},
    Verb{.name = "thickness",
         .brief = "Makes a map of a layer's thickness from a transmission photograph.",
         .run = cmd_thickness,
         .group = kMeasuring},
    Verb{.name = "register",
         .brief = "Registers scans of one object: brings them into one coordinate frame.",
         .run = cmd_register,
         .group = kMeasuring},
    Verb{.name = "grade",
         .brief = "Grades a history as standards for coatings do: rust, cracks, creep, color, gloss.",
         .run = cmd_grade,
         .group = kMeasuring},
    Verb{.name = "height-change",
         .brief = "Measures how much higher or lower a surface stands from scan to scan.",
         .run = cmd_height_change,
         .group = kMeasuring,
         .formers = {"relief"}},
    Verb{.name = "history library",
         .brief = "Lists the built-in histories, and ranks them by similarity to a photograph or a history.",
         .run = cmd_library,
         .group = kHistories,
         .formers = {"library"}},
    Verb{.name = "history trim",
         .brief = "Makes a history of part of another one's frames.",
         .run = cmd_trim,
         .group = kHistories,
         .formers = {"trim"}},
    Verb{.name = "history combine",
         .brief = "Puts several histories side by side into one, a library.",
         .run = cmd_combine,
         .group = kHistories,
         .formers = {"combine"}},
    Verb{.name = "history material",
         .brief = "Adds material properties to a history: metal, roughness, reflectance.",
         .run = cmd_material,
         .group = kHistories,
         .formers = {"history appearance", "appearance"}},
    Verb{.name = "history compare",
         .brief = "Compares how two histories age: figures, maps and curves on one page.",
         .run = cmd_compare,
         .group = kHistories,
         .formers = {"compare"}},
    Verb{.name = "history factorize",
         .brief = "Describes a history by one curve over time, and maps of gain, base, rate and offset.",
         .run = cmd_factorize,
         .group = kHistories,
         .formers = {"factorize"}},
    Verb{.name = "control accessibility",
         .brief = "Says how hard each place of a scan is to reach, in three definitions.",
         .run = cmd_accessibility,
         .group = kControls,
         .formers = {"accessibility"}},
    Verb{.name = "control explain",
         .brief = "Says which control explains where a surface has aged, and their best mix.",
         .run = cmd_explain,
         .group = kControls,
         .formers = {"explain"}},
    Verb{.name = "evaluate",
         .brief = "Measures the quality of a transfer's texture, or of another tool's.",
         .run = cmd_evaluate,
         .group = kTransfers},
    Verb{.name = "simulate restyle",
         .brief = "Gives a simulation other appearance parameters without simulating again.",
         .run = cmd_restyle,
         .group = kSimulations,
         .formers = {"simulate recompose", "recompose"}},
    Verb{.name = "fit field",
         .brief = "Fits maps of rates or initial amounts that vary from place to place.",
         .run = cmd_field,
         .group = kSimulations,
         .formers = {"field"}},
    Verb{.name = "fit rank",
         .brief = "Ranks fitted scenes by how well they predict held-out frames of a history.",
         .run = cmd_rank,
         .group = kSimulations,
         .formers = {"rank"}},
    Verb{.name = "study",
         .brief = "Runs one command on many inputs with many options: here, or through Snakemake.",
         .run = cmd_study,
         .group = kMany,
         .is_planned = false,
         .kinds = {"run", "export", "report"}},
    Verb{.name = "cluster plan",
         .brief = "Splits a command into items that can run anywhere.",
         .run = cmd_plan,
         .group = kMany,
         .formers = {"plan"},
         .is_planned = false},
    Verb{.name = "cluster run",
         .brief = "Runs items of a plan; other machines may run other items.",
         .run = cmd_run,
         .group = kMany,
         .formers = {"run"},
         .is_planned = false},
    Verb{.name = "cluster join",
         .brief = "Joins the finished items of a plan into the output.",
         .run = cmd_join,
         .group = kMany,
         .formers = {"join"},
         .is_planned = false},
    Verb{.name = "synth",
         .brief = "Makes test data with known truth: crackle, drying, dust, edges, fence, ledge, mold, panel, plate, "
                  "sculpture.",
         .run = cmd_synth,
         .group = kFiles,
         .kinds = {"crackle", "drying", "dust", "edges", "fence", "ledge", "mold", "panel", "plate", "sculpture"}},
    Verb{.name = "info", .brief = "Describes a file or folder.", .run = cmd_info, .group = kFiles, .is_planned = false},
    Verb{.name = "validate",
         .brief = "Checks a history, capture or transfer fully.",
         .run = cmd_validate,
         .group = kFiles,
         .is_planned = false},
    Verb{.name = "help",
         .brief = "Says what a command does; prints the manual.",
         .run = cmd_help,
         .group = kHelp,
         .is_planned = false},
    Verb{.name = "help completion",
         .brief = "Prints a completion script for a shell.",
         .run = cmd_completion,
         .group = kHelp,
         .formers = {"completion"},
         .is_planned = false},
    Verb{.name = "help devices",
         .brief = "Lists the devices that can calculate, and whether they give the CPU's bytes.",
         .run = cmd_devices,
         .group = kHelp,
         .formers = {"devices"},
         .is_planned = false},
};

std::span<const char* const> formers_of(const Verb& verb) {
  const auto end = std::find(std::begin(verb.formers), std::end(verb.formers), nullptr);
  return {std::begin(verb.formers), end};
}

CommandDeclaration declared(const Verb& verb, const std::vector<std::string>& arguments) {
  CommandRun run(verb.name, verb.brief, arguments, {});
  run.only_declare();
  (void)verb.run(run);
  return run.line.declaration();
}

}  // namespace

std::span<const Verb> verbs() { return kVerbs; }

std::optional<FoundVerb> find_verb(std::span<const std::string> words) {
  if (words.empty()) return std::nullopt;
  const auto find = [](const std::string& name, std::size_t num_words) -> std::optional<FoundVerb> {
    for (const Verb& verb : kVerbs) {
      if (name == verb.name) return FoundVerb{&verb, num_words};
      for (const char* former : formers_of(verb)) {
        if (name == former) return FoundVerb{&verb, num_words, former};
      }
    }
    return std::nullopt;
  };
  if (words.size() > 1) {
    if (auto found = find(words[0] + " " + words[1], 2)) return found;
  }
  return find(words[0], 1);
}

bool is_below(const Verb& verb, const std::string& word) { return std::string_view(verb.name).starts_with(word + " "); }

std::vector<std::string> parts_of(const std::string& word) {
  std::vector<std::string> parts;
  for (const Verb& verb : kVerbs) {
    if (is_below(verb, word)) parts.emplace_back(std::string_view(verb.name).substr(word.size() + 1));
  }
  return parts;
}

std::vector<std::string> first_words() {
  std::vector<std::string> words;
  for (const Verb& verb : kVerbs) {
    const std::string word = split(verb.name, ' ').front();
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  }
  return words;
}

std::vector<std::string> by_present_name(const std::vector<std::string>& words) {
  const std::optional<FoundVerb> found = find_verb(words);
  if (!found) return words;
  std::vector<std::string> all = split(found->verb->name, ' ');
  all.insert(all.end(), words.begin() + static_cast<std::ptrdiff_t>(found->num_words), words.end());
  return all;
}

void fail_no_verb(std::span<const std::string> words) {
  const std::string& word = words.front();
  if (const std::vector<std::string> parts = parts_of(word); !parts.empty()) {
    std::string list;
    for (const std::string& part : parts) list += (list.empty() ? "" : ", ") + part;
    throw app::UsageError(word + ": expected one of " + list + " behind it" +
                          (words.size() > 1 ? did_you_mean(words[1], parts) : "") + "; see `patinate " + word +
                          " --help`");
  }
  std::vector<std::string> names = first_words();
  for (const Verb& verb : kVerbs) {
    for (const char* former : formers_of(verb)) names.emplace_back(former);
  }
  throw app::UsageError(word + ": no such command" + did_you_mean(word, names) + "; see `patinate --help`");
}

CommandDeclaration declaration_of(const Verb& verb) {
  CommandDeclaration all = declared(verb, {});
  for (const char* former : formers_of(verb)) all.formers.emplace_back(former);
  for (const char* const* kind = verb.kinds; *kind != nullptr; ++kind) {
    for (ArgumentInfo& argument : declared(verb, {*kind}).arguments) {
      const auto same = std::find_if(all.arguments.begin(), all.arguments.end(),
                                     [&](const auto& a) { return a.name == argument.name; });
      if (same == all.arguments.end()) {
        argument.help = std::string(*kind) + ": " + argument.help;
        all.arguments.push_back(std::move(argument));
      } else if (!same->is_common && same->help != argument.help) {
        same->help += "; " + std::string(*kind) + ": " + argument.help;
        if (same->type != argument.type) same->type = ValueType::Number;
        same->default_text.clear();
      }
    }
  }
  return all;
}

std::vector<CommandDeclaration> all_declarations() {
  std::vector<CommandDeclaration> all;
  all.reserve(kVerbs.size());
  for (const Verb& verb : kVerbs) all.push_back(declaration_of(verb));
  return all;
}

namespace {

/// Words, and before them what stands for the arguments that the command cannot do without.
std::vector<std::string> completed(const Verb& verb, const std::vector<std::string>& words, const std::string& output) {
  std::vector<std::string> all;
  bool has_output = false;
  for (const ArgumentInfo& a : declaration_of(verb).arguments) {
    has_output = has_output || a.name == "-o";
    if (!a.is_required || a.name == "-o") continue;
    if (!a.is_positional()) all.push_back(a.name);
    all.emplace_back(".");  // A folder that is there.
  }
  if (has_output) all.insert(all.end(), {"-o", output});
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

}  // namespace

void check_options(const Verb& verb, const std::vector<std::string>& words) {
  CommandRun run(verb.name, verb.brief, completed(verb, words, "made"), {});
  run.only_declare();
  (void)verb.run(run);
}

void check_arguments(const Verb& verb, const std::vector<std::string>& words, const std::string& output) {
  CommandRun run(verb.name, verb.brief, completed(verb, words, output), {});
  run.only_check();
  (void)verb.run(run);
}

namespace {

/// Row of two columns, with what stands between them.
std::string row(const std::string& left, const std::string& right, std::size_t width = 17) {
  std::string text = "  " + left;
  text.resize(std::max(width, text.size() + 1), ' ');
  return text + right + "\n";
}

}  // namespace

std::string overview() {
  std::string text =
      "Captures how materials age and lets any mesh age like them.\n\nUsage: patinate COMMAND [arguments]\n";
  const std::span<const Verb> all(kVerbs);
  const char* group = nullptr;
  for (const Verb& verb : all.first(kNumMain)) {
    if (verb.group != group) text += std::string("\n") + verb.group + ":\n";
    group = verb.group;
    text += row(verb.name, verb.brief);
  }
  text += "\nMore commands:\n";
  for (std::size_t i = kNumMain; i < all.size();) {
    std::string names, before;
    for (group = all[i].group; i < all.size() && all[i].group == group; ++i) {
      const std::vector<std::string> words = split(all[i].name, ' ');
      // "history trim | combine": the word that several begin with is said once.
      names += words.size() > 1 && words[0] == before ? " | " + words[1]
                                                      : (names.empty() ? "" : ", ") + std::string(all[i].name);
      before = words[0];
    }
    text += row(group, names);
  }
  return text + "\n`patinate COMMAND --help` says more. `patinate --version` prints the version.\n";
}

std::string overview_of(const std::string& word) {
  std::string text = "Usage: patinate " + word + " COMMAND [arguments]\n\n";
  for (const Verb& verb : kVerbs) {
    if (is_below(verb, word)) text += row(verb.name, verb.brief, 24);
  }
  return text + "\n`patinate " + word + " COMMAND --help` says more.\n";
}

}  // namespace patinate::cli
