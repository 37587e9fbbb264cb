#include "patinate/capture/make_history.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "capture/job/plan_history.h"
#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "libcommon/job/job.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

IngestOptions ingest_options(const MakeHistoryOptions& options) {
  IngestOptions ingest;
  ingest.add_progress = options.add_progress;
  ingest.repair.stabilize = options.stabilize;
  ingest.repair.deflicker = options.deflicker;
  ingest.repair.flat_field = options.flat_field;
  ingest.repair.highlights = options.keep_highlights ? HighlightRule::Keep : HighlightRule::Mask;
  return ingest;
}

using OptionValues = std::vector<std::pair<std::string, std::string>>;

/// @param are_given  Names and values. @param otherwise  What they are where nothing is asked for.
template <typename Names>
void refuse(const OptionValues& are_given, const OptionValues& otherwise, const Names& names, const std::string& why) {
  for (std::size_t i = 0; i < are_given.size(); ++i) {
    const auto& [name, value] = are_given[i];
    if (value != otherwise[i].second && std::find(names.begin(), names.end(), name) != names.end())
      throw InvalidInput(name + ": " + why);
  }
}

}  // namespace

std::vector<std::string> lamp_options() {
  std::vector<std::string> names;
  for (const auto& [name, value] : option_values(RelitOptions{})) {
    if (name != "accept_failed") names.push_back(name);
  }
  return names;
}

JobPlan plan_history(const std::filesystem::path& capture, const std::filesystem::path& output, IngestOptions options,
                     RelitOptions relit) {
  const std::filesystem::path file = capture_file(capture);
  if (is_relit_capture(file)) {
    refuse(option_values(options), option_values(IngestOptions{}), kFixedCameraOptions,
           "is for captures of a fixed camera; " + file.string() + " is of kind relit");
    relit.scan = options.scan;
    relit.fill = options.repair.fill;
    relit.progress = options.progress;
    return plan_relit_ingest(read_relit_project(file), relit, output);
  }
  refuse(option_values(relit), option_values(RelitOptions{}), lamp_options(),
         "is for captures under lamps (kind relit); " + file.string() + " is of a fixed camera");
  options.accept_failed = relit.accept_failed;
  return plan_ingest(read_capture_project(file, options.align, options.chart), options, output);
}

void make_history(const std::filesystem::path& capture, const std::filesystem::path& output,
                  const MakeHistoryOptions& options, const RunControl& control) {
  run_job(plan_history(capture, output, ingest_options(options), {}), {.force = options.force}, control);
}

}  // namespace patinate::capture
