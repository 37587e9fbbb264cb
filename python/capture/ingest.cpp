#include <pybind11/stl.h>

#include <filesystem>
#include <utility>

#include "app/capture/drafted_project.h"
#include "capture/job/plan_history.h"
#include "capture/timelapse/repair.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "python/bindings.h"
#include "python/history/given_history.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

struct IngestKeywords {
  capture::IngestOptions options = {};
  capture::RelitOptions relit = {};
};
void describe(OptionVisitor& v, IngestKeywords& o) {
  describe(v, o.options);
  describe(v, o.relit);
}

py::dict survey_dict(const capture::SurveyReport& report) {
  py::list findings;
  for (const capture::SurveyFinding& finding : report.findings) {
    py::dict dict;
    dict["photo"] = finding.photo.name;
    dict["time"] = finding.photo.time;
    dict["problem"] = finding.problem;
    findings.append(dict);
  }
  py::list unlinked;
  for (const capture::SurveyOutsider& outsider : report.unlinked) unlinked.append(outsider.photo.name);
  py::dict out;
  out["findings"] = findings;
  out["unlinked"] = unlinked;
  out["is_stabilized"] = report.is_stabilized;
  out["is_deflickered"] = report.is_deflickered;
  out["masked_share"] = report.masked_share;
  out["outside_share"] = report.outside_share;
  return out;
}

}  // namespace

void bind_ingest(py::module_& module) {
  define(
      module,
      FunctionText("init", "Drafts a capture.json from a folder of photographs, for ingest().")
          .takes("folder", "str | os.PathLike[str]", "Folder of photographs, or with a movie")
          .keyword("output", "str | os.PathLike[str] | None", "None", "File to write; None: capture.json in the folder")
          .keyword("only", "str", "''", "Names of the photographs, as 'IMG_*.jpg', where others lie beside them")
          .keyword("force", "bool", "False", "Replace a different file that lies there")
          .returns("Report",
                   "project: the file; found and check: what was recognized, and what was guessed, a line each; "
                   "refusal: why ingest() will not take it as it is, or ''")
          .raises("IoError if the folder holds no photographs, or several sets; CannotComplete"),
      [](const py::object& given, const py::kwargs& kwargs) {
        Keywords keywords("init", kwargs);
        const std::filesystem::path folder = path_from(given);
        std::filesystem::path output = keywords.text("output", "");
        const std::string only = keywords.text("only", "");
        const bool force = keywords.flag("force", false);
        keywords.finish();
        if (output.empty()) output = folder / "capture.json";
        auto [draft, refusal] = result_of({}, [=](const RunControl&) {
          capture::ProjectDraft made = capture::draft_capture_project(folder, output.parent_path(), only);
          app::make_output(app::drafted_project_work(made, output), force, {});
          return std::pair(std::move(made), app::draft_refusal(output));
        });
        py::dict out;
        out["project"] = output.string();
        out["found"] = draft.found;
        out["check"] = draft.to_check;
        out["refusal"] = refusal;
        return out;
      });
  define(module,
         FunctionText("ingest",
                      "Makes a history folder of a capture: photographs from a fixed camera, or scans under lamps.")
             .takes("capture", "str | os.PathLike[str]", "A capture.json, or the folder that holds it")
             .takes("output", "str | os.PathLike[str]",
                    "The history's folder, which appears when it is whole; a run that was ended is resumed, a finished "
                    "one stays as it is")
             .keyword("force", "bool", "False", "Replace a different history that lies there")
             .options<IngestKeywords>()
             .runs()
             .returns("History")
             .raises("IoError if a file cannot be read; InvalidInput; CannotComplete if something else lies there"),
         [](const py::object& capture, const py::object& output, const py::kwargs& kwargs) {
           Keywords keywords("ingest", kwargs);
           IngestKeywords options;
           keywords.read(options);
           const bool force = keywords.flag("force", false);
           const RunArguments run = keywords.run();
           keywords.finish();
           const std::string from = path_from(capture), to = path_from(output);
           return PyHistory{result_of(run, [=](const RunControl& control) {
             run_job(capture::plan_history(from, to, options.options, options.relit), {.force = force}, control);
             return std::make_shared<const HistoryReader>(to);
           })};
         });
  define(
      module,
      FunctionText("survey", "What ingest found wrong with a time-lapse: moved, flickering, jumping photographs.")
          .takes("history", "History | str | os.PathLike[str]", "As ingest() made it, or its folder")
          .returns(
              "Report",
              "findings: photo, time, problem of each; unlinked: photographs that cannot be aligned with most of the "
              "others; "
              "is_stabilized, is_deflickered; masked_share of all pixels of all frames, outside_share of the pixels")
          .raises("IoError"),
      [](const py::object& history) {
        const GivenHistory given = given_history("survey", "history", history);
        if (given.memory) throw InvalidInput("history: is in memory only; ingest() looks at photographs");
        return survey_dict(result_of({}, [=](const RunControl&) { return capture::read_survey_report(given.path); }));
      });
}

}  // namespace patinate::python
