#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/ingest/ingest.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history.h"
#include "tools/patinate/commands.h"
#include "tools/patinate/path_kind.h"

namespace patinate {

namespace {

/// Says what is likely to spoil a transfer: much that never ages, or a thickness that a saturated or opaque part stretches.
void note_doubtful_controls(const HistoryReader& history, CommandRun& run) {
  for (const ControlParameter& c : history.manifest().controls) {
    if (c.name == "thickness" && c.low > 0.0 && c.high / c.low > 50.0) {
      run.note("thickness spans 1 to " + short_number_text(c.high / c.low) + ": saturated or opaque parts belong outside the `mask`");
    }
    if (c.name != "progress") continue;
    const ImageF values = history.read_control(c.name);
    const ImageU8 mask = history.read_mask();
    std::int64_t num_inside = 0, num_unchanged = 0;
    for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
      num_inside += mask.data()[i] != 0;
      num_unchanged += mask.data()[i] != 0 && values.data()[i] == 0.0f;
    }
    if (10 * num_unchanged > num_inside) {
      run.note(short_number_text(std::round(100.0 * static_cast<double>(num_unchanged) / static_cast<double>(num_inside))) +
               " % of the pixels never change: give a `mask`, or transfers will copy them too");
    }
  }
}

}  // namespace

int cmd_ingest(CommandRun& run) {
  std::filesystem::path project_file, output;
  IngestOptions options;
  run.line.positional("CAPTURE", "capture.json, or the folder that holds it (docs/capture.md)", project_file);
  run.line.output("HISTORY", "Folder of the material history to make", output);
  run.line.options(options);
  run.line.example("ingest photos/capture.json -o copper");
  if (!run.parse()) return 0;

  const CaptureProject project = read_capture_project(capture_file(project_file));
  const JobPlan plan = plan_ingest(project, options, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "ingest");
  if (!status) return 0;
  const HistoryReader reader(output);
  note_doubtful_controls(reader, run);

  const HistoryManifest& history = reader.manifest();
  Json controls = Json::array();
  for (const ControlParameter& c : history.controls) controls.push_back(c.name);
  run.report_output(*status, output, Json{{"frames", history.frames.size()}, {"controls", controls}});
  return 0;
}

}  // namespace patinate
