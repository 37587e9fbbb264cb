#include "app/history/trimmed_history.h"

#include <vector>

#include "libcommon/job/job_inputs.h"
#include "patinate/history/history.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::app {

namespace fs = std::filesystem;

JobPlan plan_trim(const fs::path& history, const TrimOptions& options, const fs::path& output) {
  const HistoryReader reader(history);
  TrimmedHistory trimmed = trim_history(reader.manifest(), options);
  JobInputs inputs("trim", 1);
  inputs.add_content("history", "the history", transfer::history_content_key(reader));
  inputs.add_options(option_values(options));
  JobPlan plan = inputs.plan(output, kHistoryManifestFile);
  trimmed.manifest.key = plan.key;
  std::vector<fs::path> outputs;
  for (const TrimmedHistory::File& file : trimmed.files) outputs.push_back(file.to);
  plan.items.push_back(
      {.name = "files",
       .outputs = outputs,
       .run = [from = reader.folder(), files = trimmed.files](const fs::path& folder, const RunControl& control) {
         copy_history_files(from, files, folder, control);
       }});
  plan.join = [manifest = trimmed.manifest](const fs::path& folder, const RunControl&) {
    write_history_manifest(folder / kHistoryManifestFile, manifest);
  };
  return plan;
}

}  // namespace patinate::app
