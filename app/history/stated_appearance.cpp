#include "app/history/stated_appearance.h"

#include <vector>

#include "libcommon/history/appearance_json.h"
#include "libcommon/history/stated_history.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/history/trim_history.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::app {

namespace fs = std::filesystem;

namespace {

std::optional<StatedValue> constant(const std::optional<double>& value) {
  if (!value) return std::nullopt;
  return StatedValue{.curve = {{{0.0, *value}}}};
}

}  // namespace

void describe(OptionVisitor& v, PlainAppearance& o) {
  v.visit({"metalness", "For all places and times: 0 = no metal, 1 = metal", "", between(0, 1)}, o.metalness);
  v.visit({"roughness", "Roughness for all places and times: 0 = polished, 1 = matte", "", between(0, 1)}, o.roughness);
  v.visit({"specular", "Reflectance of nonmetals at normal incidence, for all places and times", "", between(0, 1)},
          o.specular);
}

Appearance appearance_of(const fs::path& file, const PlainAppearance& plain) {
  Appearance numbers;
  numbers.metalness = constant(plain.metalness);
  numbers.roughness = constant(plain.roughness);
  numbers.specular = constant(plain.specular);
  if (file.empty() == numbers.is_empty())
    throw InvalidInput("appearance: expected a file, or metalness, roughness or specular, and not both");
  return file.empty() ? numbers : read_appearance_file(file);
}

JobPlan plan_appearance(const fs::path& folder, const Appearance& appearance, const fs::path& output) {
  const HistoryReader reader(folder);
  check_appearance(reader.facts(), appearance);
  TrimmedHistory all = trim_history(reader.manifest(), {});
  JobInputs inputs("appearance", 1);
  inputs.add_content("history", "the history", transfer::history_content_key(reader));
  inputs.add_value("appearance", appearance_key(appearance));
  JobPlan plan = inputs.plan(output, kHistoryManifestFile);
  all.manifest.key = plan.key;
  std::vector<fs::path> outputs;
  for (const TrimmedHistory::File& file : all.files) outputs.push_back(file.to);
  plan.items.push_back(
      {.name = "files",
       .outputs = outputs,
       .run = [from = reader.folder(), files = all.files](const fs::path& to, const RunControl& control) {
         copy_history_files(from, files, to, control);
       }});
  plan.join = [manifest = all.manifest, appearance](const fs::path& made, const RunControl& control) {
    write_history_manifest(made / kHistoryManifestFile, manifest);
    state_appearance(made, appearance, mask_reader(facts_of(manifest)), control);
  };
  return plan;
}

}  // namespace patinate::app
