#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/unlighting/unlight_job.h"
#include "libcommon/core/text.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

int cmd_unlight(CommandRun& run) {
  std::filesystem::path step_file, output;
  capture::UnlightOptions options;
  run.line.positional("STEP", "A step.json: photographs, lights and scan (docs/unlighting.md)", step_file);
  run.line.output("FOLDER", "Folder of maps to make: albedo, standard deviation, normals, highlights, a report",
                  output);
  run.line.options(options);
  run.line.usual({"normals", "specular", "strengths", "ambient", "interreflection"});
  run.line.example("unlight step.json -o unlit");
  run.line.example("unlight cat.json --strengths -o cat");
  if (!run.parse()) return 0;

  const capture::UnlightStep step = capture::read_unlight_step(step_file);
  const JobPlan plan = capture::plan_unlight(step, options, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "unlight");
  if (!status) return 0;
  Json made = load_json(output / capture::kUnlitManifestFile);
  update_spelling(made, 1, {{"left_out", "leave_one_out"}});
  for (const std::string& note : step.notes) run.note(note);
  for (const Json& note : made.at("notes")) run.note(note.get<std::string>());
  const double determined = made.at("determined_pixels").get<double>(),
               surface = made.at("surface_pixels").get<double>();
  double predicted = 0.0;
  for (const Json& light : made.at("lights"))
    predicted += light.at("leave_one_out").at("rms").get<double>() / static_cast<double>(made.at("lights").size());
  run.note("albedo is known for " + percent_text(determined / surface) + " of the surface; residual " +
           percent_text(made.at("residual").get<double>()) +
           "; photographs that are predicted from the others differ by " + percent_text(predicted));
  run.report_output(*status, output,
                    Json{{"determined_pixels", made.at("determined_pixels")},
                         {"surface_pixels", made.at("surface_pixels")},
                         {"residual", made.at("residual")},
                         {"leave_one_out", predicted},
                         {"is_converged", made.at("is_converged")},
                         {"notes", made.at("notes")}});
  return made.at("is_converged").get<bool>() ? 0 : 1;
}

}  // namespace patinate::cli
