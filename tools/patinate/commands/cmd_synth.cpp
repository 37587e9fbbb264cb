#include "datasets_synthetic/crackle_io.h"
#include "datasets_synthetic/mold_io.h"
#include "datasets_synthetic/object_io.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

const std::vector<std::string> kKinds{"crackle", "fence", "ledge", "mold", "sculpture"};

}  // namespace

int cmd_synth(CommandRun& run) {
  std::string kind;
  std::filesystem::path output;
  datasets::CrackleOptions crackle_options;
  datasets::FenceOptions fence_options;
  datasets::LedgeOptions ledge_options;
  datasets::MoldOptions mold_options;
  datasets::SculptureOptions sculpture_options;
  run.line.positional("KIND",
                      "crackle (a capture project with its truth), mold (one of scans and lights, with its truth), "
                      "ledge or fence (scenes to simulate) or sculpture (a mesh to age)",
                      kind);
  run.line.choices(kKinds);
  run.line.output("FOLDER", "Folder to make", output);
  // Each kind has options of its own, so the kind decides what --help lists and what is accepted.
  const std::string asked = run.first_positional();
  if (asked == "crackle") run.line.options(crackle_options);
  if (asked == "fence") run.line.options(fence_options);
  if (asked == "ledge") run.line.options(ledge_options);
  if (asked == "mold") run.line.options(mold_options);
  if (asked == "sculpture") run.line.options(sculpture_options);
  run.line.example("synth crackle -o crackle");
  run.line.example("synth mold -o mold --exact");
  run.line.example("synth ledge -o ledge");
  run.line.example("synth ledge -o washed --weather soot");
  run.line.example("synth fence -o fence");
  run.line.example("synth crackle --help");
  if (!run.parse()) return 0;
  const JobPlan plan = kind == "crackle" ? datasets::plan_crackle(crackle_options, output)
                       : kind == "fence" ? datasets::plan_fence(fence_options, output)
                       : kind == "ledge" ? datasets::plan_ledge(ledge_options, output)
                       : kind == "mold"  ? datasets::plan_mold(mold_options, output)
                                         : datasets::plan_sculpture(sculpture_options, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "synth " + kind);
  if (status) run.report_output(*status, output);
  return 0;
}

}  // namespace patinate::cli
