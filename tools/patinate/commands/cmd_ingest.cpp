#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "capture/job/plan_history.h"
#include "capture/project/photo_facts.h"
#include "capture/report/report_sections.h"
#include "capture/timelapse/chart_report.h"
#include "capture/timelapse/mask_warnings.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_documents.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

/// Says what is likely to spoil a transfer: much that never ages, or a thickness that a saturated or opaque part
/// stretches.
void note_doubtful_controls(const HistoryReader& history, CommandRun& run) {
  for (const ControlParameter& c : history.manifest().controls) {
    if (c.name == "thickness" && c.low > 0.0 && c.high / c.low > 50.0) {
      run.warn("thickness spans 1 to " + short_number_text(c.high / c.low) +
               ", probably because parts are saturated or opaque; exclude these with a `mask`");
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
      run.warn(
          short_number_text(std::round(100.0 * static_cast<double>(num_unchanged) / static_cast<double>(num_inside))) +
          " % of the pixels never change, and transfers will copy them too; if they are background, give "
          "--mask-background plain (around it, one color) or unchanging, or a `mask`");
    }
  }
}

/// A single photograph has no survey: its shares are those of its own mask.
void complete_shares(const HistoryReader& reader, capture::SurveyReport& survey) {
  const auto& frames = reader.manifest().frames;
  if (frames.size() != 1 || !frames[0].mask) return;
  const ImageU8 mask = read_mask(reader.folder() / *frames[0].mask);
  const auto num_masked = std::count(mask.values().begin(), mask.values().end(), 0);
  survey.masked_share = static_cast<double>(num_masked) / static_cast<double>(mask.num_pixels());
  survey.outside_share = survey.masked_share;
}

/// Says once for all what the photographs' files say of how they are to be seen.
void note_photo_facts(const capture::CaptureProject& project, CommandRun& run) {
  std::vector<std::pair<std::string, ImageFacts>> all, coded;  // A response applies to codes alone.
  for (const capture::CapturePhoto& photo : project.frames) {
    all.emplace_back(photo.name(), photo.facts);
    if (photo.has_codes) coded.push_back(all.back());
  }
  for (const std::string& line : capture::series_facts(all)) run.note(line);
  if (const std::string text = capture::override_text(coded, project.response); !text.empty()) run.note(text);
}

/// Says what was masked where it is too little for a warning, and with --verbose every photograph that was found.
void note_survey(const capture::SurveyReport& survey, bool is_one_photo, CommandRun& run) {
  for (const capture::SurveyFinding& f : survey.findings)
    run.detail(f.photo.name + " (time " + short_number_text(f.photo.time) + "): " + f.problem);
  if (!survey.findings.empty())
    run.note(std::string("findings for each photograph are in ") + capture::kSurveyFile + "; --verbose prints them");
  if (survey.outside_share >= 0.0005 && survey.outside_share < capture::kMuchMasked) {
    run.note(fixed_percent_text(survey.outside_share) +
             (is_one_photo ? " of the pixels are saturated or in a highlight"
                           : " of the pixels are saturated, in a highlight or out of view in some photograph and "
                             "cannot be filled from others") +
             ": they are outside the mask (`--highlights keep` keeps them)");
  }
}

/// How well a transmission photograph from another pose was aligned.
void note_alignment(const std::filesystem::path& output, CommandRun& run) {
  const std::filesystem::path file = output / capture::kTransmissionFile;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return;
  const Json json = load_json(file);
  run.note("transmission photograph aligned: " + std::to_string(json.at("agreeing").get<int>()) + " places agree to " +
           short_number_text(json.at("residual_px").get<double>()) + " px");
}

/// The end of the command, with the page that says all of this with pictures.
void report_history(CommandRun& run, JobStatus status, const std::filesystem::path& output, Json more) {
  const std::filesystem::path page = output / capture::kIngestPageFile;
  run.note(page.string() + ": open this page in a browser to check how every photograph was understood");
  more["report"] = page.string();
  run.report_output(status, output, more);
}

int ingest_relit(CommandRun& run, const std::filesystem::path& file, const capture::RelitOptions& options,
                 const capture::IngestOptions& shared, const std::filesystem::path& output) {
  for (const std::string_view key : capture::kFixedCameraOptions) {
    if (run.line.is_given(std::string(key)))
      throw app::UsageError(dashed(key) + ": is for captures of a fixed camera; " + file.string() +
                            " is of kind relit");
  }
  const std::optional<JobStatus> status =
      run.make_folder(capture::plan_history(file, output, shared, options), "ingest");
  if (!status) return 0;
  const Json report = load_json(output / capture::kRelitReportFile);
  Json excluded = Json::array();
  for (const Json& step : report.at("steps")) {
    const std::string name = "step " + std::to_string(step.at("step").get<int>());
    if (!step.at("in_history").get<bool>()) {
      excluded.push_back(step.at("step"));
      run.note(name + " is excluded: " + step.at("status").get<std::string>());
      continue;
    }
    for (const Json& note : step.value("notes", Json::array())) run.note(name + ": " + note.get<std::string>());
    run.detail(name + ": " + fixed_percent_text(step.at("determined_share").get<double>()) +
               " of the surface determined");
  }
  const HistoryReader reader(output);
  say_history_warnings(run, reader.label(), reader.facts().warnings);
  Json controls = Json::array();
  for (const ControlParameter& c : reader.manifest().controls) controls.push_back(c.name);
  report_history(run, *status, output,
                 Json{{"frames", reader.num_frames()}, {"controls", controls}, {"excluded", excluded}});
  return 0;
}

}  // namespace

int cmd_ingest(CommandRun& run) {
  std::filesystem::path project_file, output;
  capture::IngestOptions options;
  capture::RelitOptions relit_options;
  run.line.positional("CAPTURE", "capture.json, or the folder that holds it (docs/capture.md)", project_file);
  run.line.output("HISTORY", "Folder of the material history to make", output);
  run.line.options(options);
  run.line.options(relit_options);
  run.line.usual({"stabilize", "deflicker", "flat_field", "highlights", "align"});
  run.line.example("ingest photos/capture.json -o copper");
  if (!run.parse()) return 0;

  if (capture::is_relit_capture(capture::capture_file(project_file)))
    return ingest_relit(run, capture::capture_file(project_file), relit_options, options, output);
  for (const std::string& key : capture::lamp_options()) {
    if (run.line.is_given(key))
      throw app::UsageError(dashed(key) + ": is for captures under lamps (kind relit); " +
                            capture::capture_file(project_file).string() + " is of a fixed camera");
  }
  options.accept_failed = relit_options.accept_failed;
  const capture::CaptureProject project =
      capture::read_capture_project(capture::capture_file(project_file), options.align, options.chart);
  const JobPlan plan = capture::plan_ingest(project, options, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "ingest");
  if (!status) return 0;
  const HistoryReader reader(output);
  note_photo_facts(project, run);
  if (project.has_raw_frames)
    run.note("camera RAW: taken as linear light, with daylight white balance; `response` does not apply to it");
  if (!project.time_span.empty()) run.note("times from " + project.time_source + ", " + project.time_span);
  if (project.time_source.find("movie") != std::string::npos)
    run.note("times from " + project.time_source + ": for a time-lapse give `interval`");
  note_alignment(output, run);
  note_doubtful_controls(reader, run);
  capture::SurveyReport survey = capture::read_survey_report(reader.folder());
  complete_shares(reader, survey);
  say_history_warnings(run, reader.label(), reader.facts().warnings);
  run.notes(capture::light_notes(survey.light));
  run.notes(capture::chart_notes(capture::read_chart(output)));
  note_survey(survey, reader.num_frames() == 1, run);

  const HistoryManifest& history = reader.manifest();
  Json controls = Json::array();
  for (const ControlParameter& c : history.controls) controls.push_back(c.name);
  Json findings = Json::array();
  for (const capture::SurveyFinding& f : survey.findings)
    findings.push_back({{"photo", f.photo.name}, {"time", f.photo.time}, {"problem", f.problem}});
  report_history(run, *status, output,
                 Json{{"frames", history.frames.size()},
                      {"controls", controls},
                      {"findings", findings},
                      {"warnings", warnings_json(history.warnings)},
                      {"masked_share", survey.masked_share},
                      {"outside_share", survey.outside_share}});
  return 0;
}

}  // namespace patinate::cli
