#include <nlohmann/json.hpp>

#include "app/device/checked_devices.h"
#include "app/request/usage_error.h"
#include "app/simulation/simulate_request.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/job/estimate.h"
#include "simulation/job/outcome_json.h"
#include "simulation/job/simulation_job.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

constexpr const char* kSimulationManifest = "simulation.json";

/// Several of one scene.
struct ReplicateOptions {
  int replicates = 0;
};

void describe(OptionVisitor& v, ReplicateOptions& o) {
  v.visit({"replicates",
           "Number of simulations, with consecutive seeds, each in a folder seed_N of the output; 0 = one, the output "
           "itself",
           "", between(0, 1000)},
          o.replicates);
}

std::string comma_list(const Json& names) {
  std::string text;
  for (const Json& name : names) text += (text.empty() ? "" : ", ") + name.get<std::string>();
  return text;
}

/// Rows of the mass ledger, in amounts on texels of median size.
std::string ledger_text(const Json& ledger) {
  static constexpr std::array kColumns{"emitted",  "made",   "on_surfaces", "carried",
                                       "absorbed", "rested", "left",        "used"};
  std::string text = "mass            ";
  const auto cell = [](std::string word) {
    return word.size() < 13 ? std::string(13 - word.size(), ' ') + word : " " + word;
  };
  for (const char* column : kColumns) text += cell(column);
  for (const auto& [material, row] : ledger.items()) {
    text += "\n" + material + std::string(material.size() < 16 ? 16 - material.size() : 1, ' ');
    for (const char* column : kColumns) text += cell(short_number_text(row.at(column).get<double>()));
  }
  return text;
}

std::string percent(const Json& share) { return fixed_percent_text(share.get<double>()); }

/// Text on what happened to each object, material by material.
std::string outcome_text(const Json& outcome) {
  std::string text;
  for (const auto& [object, facts] : outcome.at("objects").items()) {
    text += (text.empty() ? "" : "\n") + object + ": changed by " +
            short_number_text(facts.at("change_mean").get<double>()) +
            " Delta E in the mean, 95 % of it by less than " + short_number_text(facts.at("change_p95").get<double>());
    if (facts.contains("never_met_share")) text += "; never met " + percent(facts["never_met_share"]);
    for (const auto& [material, m] : facts.at("materials").items()) {
      if (m.at("largest") == 0.0) continue;
      text += "\n  " + material + std::string(material.size() < 14 ? 14 - material.size() : 1, ' ') + "mean " +
              short_number_text(m.at("mean").get<double>()) + ", most " +
              short_number_text(m.at("largest").get<double>()) + "; shows on " + percent(m.at("shows_share")) +
              ", hides all on " + percent(m.at("hides_share"));
      if (m.at("full_share") != 0.0) text += ", full on " + percent(m.at("full_share"));
    }
  }
  return text;
}

/// What became of each layer of each object.
std::string layers_text(const Json& layers) {
  std::string text;
  for (const Json& row : layers) {
    const double start = row.at("start").get<double>();
    if (!(start > 0.0)) continue;
    const auto share = [&](const char* part) { return fixed_percent_text(row.at(part).get<double>() / start); };
    text += (text.empty() ? "" : "\n") + row.at("object").get<std::string>() + ", " +
            row.at("layer").get<std::string>() + ": " + share("worn") + " worn, " + share("flaked") + " flaked, " +
            share("remains") + " remains";
  }
  return text;
}

int report_estimate(CommandRun& run, simulation::SceneFile file, const simulation::SimulationOptions& options) {
  const int resolution = file.scene.resolution;
  const simulation::RunEstimate estimate = simulation::estimate_run(std::move(file), options, run.control("estimate"));
  Json json = simulation::outcome_json(estimate.outcome);
  json["resolution"] = estimate.resolution;
  json["gammatons"] = estimate.gammatons;
  std::string text = outcome_text(json) + "\nestimated on an atlas of " + std::to_string(estimate.resolution) +
                     " in place of " + std::to_string(resolution) + " texels, with " +
                     std::to_string(estimate.gammatons) + " of " + std::to_string(estimate.all_gammatons) +
                     " gammatons";
  for (const Json& advice : json.at("advice")) run.note("warning: " + advice.get<std::string>());
  run.report(json, text);
  return 0;
}

void note_outcome(CommandRun& run, const Json& manifest) {
  if (manifest.contains("outside"))
    run.note("the folder contains its scene except " + comma_list(manifest["outside"]) +
             ", which stay where they are; keep them to open the scene again");
  if (!run.line.common().json) {
    run.note(ledger_text(manifest.at("ledger")));
    run.note(outcome_text(manifest.at("outcome")));
    if (manifest.contains("layers")) run.note(layers_text(manifest["layers"]));
  }
  for (const Json& advice : manifest.at("outcome").at("advice")) run.note("warning: " + advice.get<std::string>());
}

Json written_simulation_facts(const Json& manifest) {
  return {{"counters", manifest.at("counters")},
          {"ledger", manifest.at("ledger")},
          {"outcome", manifest.at("outcome")},
          {"atlas_hash", manifest.at("atlas_hash")}};
}

/// One simulation a seed, from the scene's on: what a comparison of several needs. Each is a job of its own, so that
/// those that are finished stay, and more can be added.
int simulate_replicates(CommandRun& run, const simulation::SceneFile& file,
                        const simulation::SimulationOptions& options, int num_replicates,
                        const std::filesystem::path& output) {
  if (run.request() != nullptr)
    throw app::UsageError("--replicates: plans have one simulation; plan each --seed, or use `study` with seeds");
  if (std::filesystem::exists(output / kSimulationManifest))
    throw CannotComplete(output.string() + ": is a simulation; replicates need a folder of their own");
  std::error_code error;
  if (!run.line.common().dry_run) std::filesystem::create_directory(output, error);
  if (error) throw CannotComplete(output.string() + ": cannot be made; " + error.message());
  Json replicates = Json::array();
  bool is_up_to_date = true;
  for (int k = 0; k < num_replicates; ++k) {
    simulation::SceneFile one = file;
    one.scene.seed = file.scene.seed + static_cast<std::uint64_t>(k);
    const std::string name = "seed_" + std::to_string(one.scene.seed);
    const std::filesystem::path folder = output / name;
    const std::optional<JobStatus> status =
        run.make_folder(simulation::plan_simulation(std::move(one), options, folder), name);
    if (!status) continue;
    is_up_to_date = is_up_to_date && *status == JobStatus::UpToDate;
    const Json manifest = load_json(folder / kSimulationManifest);
    Json facts{{"folder", name}};
    facts.update(written_simulation_facts(manifest));
    replicates.push_back(std::move(facts));
    if (k == 0) note_outcome(run, manifest);
  }
  if (replicates.empty()) return 0;
  run.report_output(is_up_to_date ? JobStatus::UpToDate : JobStatus::Done, output,
                    Json{{"replicates", std::move(replicates)}});
  return 0;
}

}  // namespace

int cmd_simulate(CommandRun& run) {
  std::filesystem::path output;
  app::SimulateRequest request;
  ReplicateOptions replicates;
  bool is_estimate = false;
  device::DeviceOptions device;
  run.line.positional("SCENE", "A scene file (docs/simulation.md)", request.scene);
  run.line.output("SIMULATION", "Folder to make; required without --estimate", output);
  run.line.required(false);
  run.line.options(request.options);
  run.line.options(replicates);
  run.line.options(device);
  run.line.repeated("controls", "NAME",
                    "A parameter map to write for transfer, beside those that the scene asks for: hits, last_hit, "
                    "residence, MATERIAL.deposited, MATERIAL.final",
                    request.controls);
  run.line.flag("estimate", "Predict the final state from a coarse run, within seconds; write no files", is_estimate);
  run.line.example("simulate rust.json -o rust");
  run.line.example("simulate rust.json --estimate");
  run.line.example("simulate rust.json --replicates 8 -o rusted");
  run.line.example("simulate rust.json -o rust --controls hits --controls water.deposited --iterations 500");
  run.line.checked([&] { app::require_resolution(request.options); });
  if (!run.parse()) return 0;
  if (output.empty() && !is_estimate) throw app::UsageError("-o SIMULATION is missing; --estimate needs none");
  if (!output.empty() && is_estimate) throw app::UsageError("--estimate makes nothing; leave out -o");
  if (replicates.replicates > 0 && is_estimate)
    throw app::UsageError("--estimate is of one simulation; leave out --replicates");
  const auto simulation_device = app::open_simulation_device(device, words_of(run));
  if (run.line.is_given("seed")) request.seed = run.line.common().seed;
  simulation::SceneFile file = app::read_requested_scene(request, run.control("scene"));
  run.notes(file.notes);
  if (simulation_device && simulation::has_layers(file.scene))
    run.note("the scene has layers: it runs on the CPU, and the device is not used");
  simulation::SimulationOptions simulation;
  simulation.color_form = request.options.color_form;
  simulation.device = simulation_device;
  if (is_estimate) return report_estimate(run, std::move(file), simulation);
  if (replicates.replicates > 0) return simulate_replicates(run, file, simulation, replicates.replicates, output);
  const std::optional<JobStatus> status =
      run.make_folder(simulation::plan_simulation(std::move(file), simulation, output), "simulate");
  if (!status) return 0;
  const Json manifest = load_json(output / kSimulationManifest);
  note_outcome(run, manifest);
  run.report_output(*status, output, written_simulation_facts(manifest));
  return 0;
}

}  // namespace patinate::cli
