#include <nlohmann/json.hpp>
#include <utility>

#include "app/request/output_file.h"
#include "app/transfer/transfer_work.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/declared_options.h"
#include "transfer/job/forecast.h"

namespace patinate::cli {

int cmd_transfer(CommandRun& run) {
  app::TransferRequest request;
  std::filesystem::path output;
  run.line.positional("HISTORY", "A material history, or a simulation", request.history);
  declare_mesh(run.line, request.mesh);
  run.line.output("TRANSFER", "Folder to make", output);
  run.line.repeated(
      "control", "SPEC",
      "[SOURCE=]DESTINATION[:weight[:mapping]]: a control of the history, and where on the mesh it is high: a kind "
      "(accessibility, facing(direction=x): `patinate control --help-all`), a map file or an expression; mapping: "
      "auto, rank, linear, physical",
      request.controls);
  run.line.required();
  run.line.options(request.atlas);
  run.line.default_text("resolution",
                        "as many as show every pixel of the history, 256 to 4096 along a side of all tiles together, "
                        "where its texel size and the mesh's unit are known, else " +
                            std::to_string(request.atlas.resolution));
  run.line.option("texel_size", "MM", "Surface length of one pixel of the history; default: what the history says",
                  request.texel_size_mm);
  run.line.option("source_mask", "FILE", "8-bit image of the history's size; pixels that are 0 are not copied",
                  request.source_mask);
  run.line.option(
      "flow", "FLOW",
      "Which way the history's photographs lie on the surface: gravity (their down runs down, by --up), curvature "
      "(along tubes and ridges), uv (as each chart lies), "
      "or a CSV of curves (x,y,z in mm, an empty line ends one) that their down follows",
      request.flow);
  run.line.option(
      "edits", "FILE",
      "Edits of the finished transfer, in order: strokes that paint its control, as `patinate studio` saves "
      "them (`patinate help --schema edits`)",
      request.edits);
  run.line.former_flag("by_tile", "is not needed any more; a transfer takes 23 to 35 bytes a texel of the atlas");
  run.line.options(request.transfer);
  run.line.options(request.cache);
  run.line.options(request.device);
  declare_kind_options(run.line, request.kinds, {"up"});  // --flow looks at it too.
  run.line.usual({"unit", "resolution", "texel_size", "quality"});
  run.line.example(
      "transfer copper hydrant.gltf --material fire_hydrant --control progress=accessibility -o copper_hydrant");
  run.line.example("transfer library bust.glb --control thickness=accessibility --control history=which.png -o aged");
  run.line.example(
      "transfer crackle vase.obj --unit mm --control 'thickness=0.7*facing + 0.3*!accessibility' -o crackle_vase");
  run.line.example("transfer crackle vase.obj --control thickness=facing --edits strokes.json -o painted");
  run.line.checked([&] { app::check_request(request); });
  if (!run.parse()) return 0;
  app::require_no_file_name(output);  // Said before the mesh and its controls are made ready.
  request.is_resolution_given = run.line.is_given("resolution");
  request.transfer.seed = run.line.common().seed;
  transfer::TransferEdits edits = app::requested_edits(request);
  transfer::TransferTask task = app::transfer_task(request, words_of(run));
  refer_to_history_warnings(run, task.history->label(), task.history->facts().warnings);
  const auto forecast = transfer::forecast_transfer(task.input, request.transfer.neighborhood_radius_px);
  for (const std::string& warning : transfer::warnings_of(forecast)) run.warn(warning);
  const std::optional<JobStatus> status =
      run.make_folder(transfer::plan_transfer(std::move(task), output, std::move(edits)), "transfer");
  if (!status) return 0;
  const transfer::TransferManifest made = transfer::read_transfer_manifest(output);
  for (const std::string& note : app::transfer_notes(made, request.transfer)) run.note(note);
  run.report_output(*status, output, transfer::energy_json(made.energy));
  return 0;
}

}  // namespace patinate::cli
