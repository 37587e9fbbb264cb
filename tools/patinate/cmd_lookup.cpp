#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_io.h"
#include "tools/patinate/commands.h"
#include "tools/patinate/output_file.h"
#include "transfer/lookup/transfer_reader.h"

namespace patinate {

int cmd_lookup(CommandRun& run) {
  std::filesystem::path path, output;
  std::optional<double> time;
  run.line.positional("TRANSFER", "A transfer folder", path);
  run.line.output("IMAGE", "Texture to write: .png, .jpg or .tif in sRGB, .exr linear", output);
  run.line.option("time", "T", "Any time of the history, in its unit; frames are blended between their times", time);
  run.line.required();
  run.line.example("lookup copper_hydrant --time 120 -o hydrant_120.png");
  if (!run.parse()) return 0;
  require_extension(output, image_extensions());

  const TransferReader transfer(path);
  const HistoryManifest& history = transfer.history().manifest();
  const double first = history.frames.front().time, last = history.frames.back().time;
  if (*time < first || *time > last) {
    run.note("time " + number_text(*time) + " is outside the history (" + number_text(first) + " to " + number_text(last) + " " +
             time_unit_text(history.time_unit) + "): its end is used");
  }
  const std::string key = ContentHash().add("lookup 1").add(transfer.manifest().key).add(*time).hex();
  const std::optional<JobStatus> status = run.check_file(output, image_file_key(output), key);
  if (!status) return 0;
  if (status == JobStatus::Done) write_color(output, transfer.sample(*time, run.control("lookup")), key);
  run.report_output(*status, output);
  return 0;
}

}  // namespace patinate
