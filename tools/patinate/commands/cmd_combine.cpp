#include <nlohmann/json.hpp>

#include "app/history/layered_history.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "transfer/library/library_job.h"

namespace patinate::cli {

namespace {

/// NAME=A,B,...: a control of the library and the one of each history that becomes it. @throws UsageError
transfer::LibraryControl parse_library_control(const std::string& text, std::size_t num_histories) {
  const auto fail = [&](const std::string& problem) {
    throw app::UsageError("--control " + text + ": " + problem +
                          "; use NAME=A,B,... with a control of each history, in their order");
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) fail("the library's name for it is missing");
  transfer::LibraryControl control{.name = text.substr(0, equals), .sources = split(text.substr(equals + 1), ',')};
  for (const std::string& source : control.sources) {
    if (source.empty()) fail("a control has no name");
  }
  if (control.sources.size() != num_histories)
    fail("names " + std::to_string(control.sources.size()) + " controls for " + std::to_string(num_histories) +
         " histories");
  return control;
}

Json parts_json(const transfer::LibraryLayout& layout) {
  Json parts = Json::array();
  for (const LibraryPart& part : layout.parts)
    parts.push_back({{"name", part.name}, {"x", part.x}, {"width", part.width}, {"height", part.height}});
  return parts;
}

/// The second history inside the first.
int combine_layers(CommandRun& run, const transfer::LibraryTask& task, const std::string& where,
                   const std::filesystem::path& output) {
  if (task.histories.size() != 2)
    throw app::UsageError("--where: found " + std::to_string(task.histories.size()) +
                          " histories; expected two, the lower and the one that lies in it");
  if (run.line.is_given("control") || run.line.is_given("texel_size"))
    throw app::UsageError(
        "--where keeps the controls and the pixels of the first history; leave out --control and "
        "--texel-size");
  const JobPlan plan = app::plan_layers(task.histories[0], task.histories[1], where, task.options.clock, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "combine");
  if (!status) return 0;
  run.report_output(*status, output, frames_json(output));
  return 0;
}

}  // namespace

int cmd_combine(CommandRun& run) {
  transfer::LibraryTask task;
  std::string where;
  std::filesystem::path output;
  std::vector<std::string> control_texts;
  run.line.positional_list("HISTORY",
                           "Two histories or more (or simulations); in the library they have the indices 0, 1, ...",
                           task.histories);
  run.line.output("LIBRARY", "Folder to make: one history, in which they lie side by side, or one in another (--where)",
                  output);
  run.line.repeated("control", "SPEC",
                    "NAME=A,B,...: a control of the library made of control A of the first history, B of the second "
                    "...; controls that all have under one name come by themselves",
                    control_texts);
  run.line.option("where", "EXPR",
                  "Put the second history inside the first, where this is above a half, from that time on: an "
                  "expression of the first one's controls and of `height` (mm), `metalness`, `roughness`, `lightness`, "
                  "`change`",
                  where);
  run.line.options(task.options);
  run.line.without({"seed"});
  run.line.example("history combine copper clay --clock span -o library");
  run.line.example("history combine crackle_thick copper --where 'smoothstep(0.1, 0.4, -height)' -o green_cracks");
  run.line.example("history combine crackle copper --control age=thickness,progress -o library");
  if (!run.parse()) return 0;
  for (const std::string& text : control_texts)
    task.controls.push_back(parse_library_control(text, task.histories.size()));
  for (std::filesystem::path& history : task.histories) {
    history = app::history_place(history);
    if (app::kind_of(history) != app::PathKind::History)
      throw InvalidInput(history.string() + ": is no history; only those can be combined");
  }
  if (!where.empty()) return combine_layers(run, task, where, output);
  const std::shared_ptr<const transfer::OpenLibrary> library = transfer::open_library(std::move(task));
  const transfer::LibraryLayout& layout = library->layout;
  run.notes(layout.notes);
  const std::optional<JobStatus> status = run.make_folder(transfer::plan_library(library, output), "combine");
  if (!status) return 0;
  Json controls = Json::array();
  for (const transfer::LibraryControl& c : layout.controls) controls.push_back(c.name);
  controls.push_back(kLibraryControl);
  run.report_output(*status, output,
                    Json{{"histories", parts_json(layout)},
                         {"width", layout.width},
                         {"height", layout.height},
                         {"frames", layout.frames.size()},
                         {"controls", controls}});
  return 0;
}

}  // namespace patinate::cli
