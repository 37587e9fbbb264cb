#include "tools/patinate/command_line/verbs.h"

#include <algorithm>
#include <array>

#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

constexpr std::array kVerbs{
    Verb{"init", "Drafts a capture project from a folder of photographs.", cmd_init},
    Verb{"ingest", "Makes a material history of photographs (capture.json).", cmd_ingest},
    Verb{"unlight", "Makes albedo and normals of photographs under known lights.", cmd_unlight},
    Verb{"calibrate",
         "Finds where camera and lights stand, or how codes become light.",
         cmd_calibrate,
         {"camera", "spheres", "lambertian", "response"}},
    Verb{"thickness", "Makes a map of a layer's thickness from a transmission photograph.", cmd_thickness},
    Verb{"register", "Brings scans of one object into one frame.", cmd_register},
    Verb{"relief", "Measures how much higher or lower a surface stands from scan to scan.", cmd_relief},
    Verb{"control", "Makes a control map of a mesh: what its aging follows.", cmd_control},
    Verb{"accessibility", "Says how hard each place of a scan is to reach, in three definitions.", cmd_accessibility},
    Verb{"explain", "Says which control explains where a surface has aged, and their best mix.", cmd_explain},
    Verb{"combine", "Lays several histories side by side in one, a library.", cmd_combine},
    Verb{"library", "Lists histories to start from, and finds those like a photograph or a history.", cmd_library},
    Verb{"trim", "Makes a history of part of another one's frames.", cmd_trim},
    Verb{"appearance", "States what a history's material is beside its color: metal, roughness, reflectance.",
         cmd_appearance},
    Verb{"transfer", "Ages a mesh with a history: source coordinates for every texel.", cmd_transfer},
    Verb{"lookup", "Writes a transfer's texture at any time.", cmd_lookup},
    Verb{"render", "Makes a picture of a transfer or simulation at a time, a strip of times, or a movie.", cmd_render},
    Verb{"evaluate", "Says how good the texture of a transfer, or of another tool, is.", cmd_evaluate},
    Verb{"export", "Writes a transfer or simulation as GLB, USD or OBJ, or a history too as images or a movie.",
         cmd_export},
    Verb{"compare", "Says how alike two histories age: figures, maps and curves on one page.", cmd_compare},
    Verb{"factorize", "Takes a history apart: one curve over time, and maps of gain, base, rate and offset.",
         cmd_factorize},
    Verb{"simulate", "Ages a scene with particles that carry water, dirt, rust.", cmd_simulate},
    Verb{"fit", "Finds a scene's numbers that age it as a history does.", cmd_fit},
    Verb{"field", "Finds where a scene's rates or initial amounts differ from place to place.", cmd_field},
    Verb{"rank", "Says which of several fitted scenes foretells a history best.", cmd_rank},
    Verb{"recompose", "Gives a simulation other appearance parameters without simulating again.", cmd_recompose},
    Verb{"studio", "Shows histories, transfers and simulations in the browser.", cmd_studio},
    Verb{"synth",
         "Makes test data with known truth: crackle, drying, dust, edges, fence, ledge, mold, plate, sculpture.",
         cmd_synth,
         {"crackle", "drying", "dust", "edges", "fence", "ledge", "mold", "plate", "sculpture"}},
    Verb{"plan", "Says what a command would do as items that can run anywhere.", cmd_plan},
    Verb{"run", "Runs items of a plan, beside others on other machines.", cmd_run},
    Verb{"join", "Makes the output of a plan's finished items.", cmd_join},
    Verb{"study",
         "Runs one command on many inputs with many options: here, or through Snakemake.",
         cmd_study,
         {"run", "export", "report"}},
    Verb{"info", "Says what a file or folder is.", cmd_info},
    Verb{"validate", "Checks a history, capture or transfer fully.", cmd_validate},
    Verb{"devices", "Lists the devices that can calculate, and whether they give the CPU's bytes.", cmd_devices},
    Verb{"completion", "Prints a completion script for a shell.", cmd_completion},
    Verb{"help", "Says what a command does; prints the manual.", cmd_help},
};

CommandDeclaration declared(const Verb& verb, const std::vector<std::string>& arguments) {
  CommandRun run(verb.name, verb.brief, arguments, {});
  run.only_declare();
  (void)verb.run(run);
  return run.line.declaration();
}

}  // namespace

std::span<const Verb> verbs() { return kVerbs; }

CommandDeclaration declaration_of(const Verb& verb) {
  CommandDeclaration all = declared(verb, {});
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

std::string overview() {
  std::string text =
      "Captures how materials age and lets any mesh age like them.\n\nUsage: patinate COMMAND "
      "[arguments]\n\nCommands:\n";
  for (const Verb& verb : kVerbs) {
    std::string name = std::string("  ") + verb.name;
    name.resize(17, ' ');
    text += name + verb.brief + "\n";
  }
  return text + "\n`patinate COMMAND --help` says more. `patinate --version` prints the version.\n";
}

}  // namespace patinate::cli
