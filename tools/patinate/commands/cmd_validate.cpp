#include <functional>
#include <nlohmann/json.hpp>

#include "analysis/explanation/explanation_report.h"
#include "analysis/factorization/factorization_job.h"
#include "analysis/fit/fit_job.h"
#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "libcommon/core/files.h"
#include "libcommon/history/history_card.h"
#include "libcommon/job/job_record.h"
#include "libcommon/job/partial_folder.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "simulation/job/simulation_job.h"
#include "tools/patinate/command_line/failure.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/capture_results.h"

namespace patinate::cli {

namespace {

/// Runs checks one after another and keeps the line of each that fails.
class Checks {
 public:
  void run(const std::function<void()>& check) {
    try {
      check();
    } catch (const InputError& e) {
      problems_.emplace_back(e.what());
    }
  }
  [[nodiscard]] const std::vector<std::string>& problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

/// Reads every pixel that the history names.
void check_history(const std::filesystem::path& path, Checks& checks, const RunControl& control) {
  const HistoryReader history(path);
  for (int i = 0; i < history.num_frames(); ++i) {
    control.throw_if_stopped();
    checks.run([&] { (void)history.read_frame(i); });
    for (const std::string& name : history.facts().frames[static_cast<std::size_t>(i)].extras)
      checks.run([&] { (void)history.read_frame_extra(i, name); });
    control.report((i + 1.0) / (history.num_frames() + 1.0));
  }
  for (const ControlParameter& c : history.manifest().controls) {
    checks.run([&] { (void)history.read_control(c.name); });
    checks.run([&] { (void)history.read_control_deviation(c.name); });
  }
  for (const std::string& name : history.facts().maps) checks.run([&] { (void)history.read_map(name); });
  checks.run([&] { (void)history.read_mask(); });
  checks.run([&] { (void)read_history_card(history.folder()); });
}

/// Decodes every photograph.
void check_capture(const capture::CaptureProject& project, Checks& checks, const RunControl& control) {
  double num_done = 0.0;
  for (const capture::CapturePhoto& frame : project.frames) {
    control.throw_if_stopped();
    checks.run([&] {
      // Of a hand-held series each photograph has a size of its own.
      if (project.is_handheld()) {
        (void)capture::read_whole_photo(project, frame);
      } else {
        (void)capture::read_photo(project, frame.file);
      }
    });
    control.report(++num_done / (static_cast<double>(project.frames.size()) + 1.0));
  }
  if (project.transmission) {
    checks.run([&] { (void)capture::read_photo(project, project.transmission->photo); });
    if (project.transmission->blank)
      checks.run([&] { (void)capture::read_photo(project, *project.transmission->blank); });
  }
  for (const capture::GivenControl& c : project.controls) {
    checks.run([&] { (void)capture::to_history_size(read_gray(c.file), project, c.file); });
  }
  checks.run([&] { (void)capture::read_capture_mask(project); });
}

void check_relit(const capture::RelitProject& project, Checks& checks, const RunControl& control) {
  for (const capture::RelitStep& step : project.steps) {
    control.throw_if_stopped();
    if (step.scan) checks.run([&] { (void)read_point_cloud(*step.scan); });
    for (const std::filesystem::path& photo : step.photos)
      checks.run([&] { (void)read_color(photo, project.response); });
    if (step.ambient) checks.run([&] { (void)read_color(*step.ambient, project.response); });
    if (step.ready) {
      checks.run([&] { (void)read_color(step.ready->albedo, project.response); });
      for (const auto& map : {step.ready->position, step.ready->normal})
        checks.run([&] { (void)read_channels(map, {"X", "Y", "Z"}); });
    }
  }
}

void check_path(const std::filesystem::path& path, Checks& checks, const RunControl& control) try {
  switch (kind_of(path)) {
    case PathKind::History:
      return check_history(path, checks, control);
    case PathKind::Transfer: {
      const transfer::TransferReader transfer(path);
      return check_history(transfer.history().folder(), checks, control);
    }
    case PathKind::Capture:
      if (capture::is_relit_capture(capture::capture_file(path)))
        return check_relit(capture::read_relit_project(capture::capture_file(path)), checks, control);
      return check_capture(capture::read_capture_project(capture::capture_file(path)), checks, control);
    case PathKind::Registration:
      return check_registration(path);
    case PathKind::Unlit:
      return check_unlit(path);
    case PathKind::Calibration:
      return check_calibration(path);
    case PathKind::Simulation: {
      const std::filesystem::path folder = manifest_folder(path, "simulation.json");
      const simulation::SimulationManifest m = simulation::read_simulation_manifest(path);
      std::vector<std::string> channels;
      for (const std::string& material : m.materials) channels.push_back("amount." + material);
      checks.run([&] { (void)read_channels(folder / "atlas.exr", channels); });
      for (const char* name : {"color.png", "normal.png", "specular.png"})
        checks.run([&] { (void)read_color(folder / name); });
      checks.run([&] { (void)read_gray(folder / "height.exr"); });
      checks.run([&] { (void)read_mesh(folder / "model.glb"); });
      for (const std::string& name : m.controls)
        checks.run([&] { (void)read_gray(folder / "controls" / (name + ".exr")); });
      return check_history(folder / "history", checks, control);
    }
    case PathKind::Factorization: {
      const analysis::FactorizationManifest m = analysis::read_factorization(path);
      for (const auto& [name, file] : m.maps)
        checks.run([&file = file] {
          (void)(file.extension() == ".png" ? read_mask(file).width()
                                            : static_cast<int>(probe_image(file).channels.size()));
        });
      for (const char* name : {"base", "gain"})
        checks.run([&] {
          (void)read_channels(
              manifest_folder(path, analysis::kFactorizationManifestFile) / "maps" / (std::string(name) + ".exr"),
              {"R", "G", "B"});
        });
      return check_history(m.history, checks, control);
    }
    case PathKind::Fit: {
      const std::filesystem::path folder = manifest_folder(path, analysis::kFitReportFile);
      const std::size_t n = analysis::read_fit_manifest(path).num_captures;
      for (std::size_t c = 0; c < n; ++c) {
        const auto file = [&](const char* stem) { return folder / analysis::file_of_capture(n, stem, c); };
        checks.run([&] { (void)simulation::read_scene(file("scene").string() + ".json", control); });
        checks.run([&] { check_history(file("before"), checks, control); });
        checks.run([&] { check_history(file("after"), checks, control); });
      }
      return;
    }
    case PathKind::Explanation: {
      const std::filesystem::path folder = manifest_folder(path, analysis::kExplanationFile);
      (void)analysis::read_explanation(path);
      for (const char* name : {analysis::kExplanationTableFile, analysis::kExplanationPageFile})
        checks.run([&] { (void)read_file(folder / name); });
      return;
    }
    case PathKind::Mesh:
      return checks.run([&] { (void)read_mesh(path); });
    case PathKind::Image:
      return checks.run([&] { (void)read_color(path); });
  }
} catch (...) {
  rethrow_naming(path);
}

/// Compares the files of a finished folder with what they were when it was made.
void check_record(const std::filesystem::path& path, Checks& checks) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::is_directory(path, error) ? path : folder_of(path);
  const JobRecord record = read_job_record(folder, manifest_key(folder, kJobRecordFile));
  const FolderDamage damage = damage_of(folder, record, Looked::AtContent);
  const auto tell = [&](const std::string& file, const char* what) {
    checks.run(
        [&] { throw IoError((folder / file).string(), std::string(what) + "; make the result again with --force"); });
  };
  for (const std::string& file : damage.lost) tell(file, "is lost");
  for (const std::string& file : damage.altered) tell(file, "is no longer what was made");
}

}  // namespace

int cmd_validate(CommandRun& run) {
  std::filesystem::path path;
  run.line.positional(
      "PATH",
      "A history, capture, transfer, simulation, fit, registration, unlit, factorization or explanation folder, a "
      "calibration, a mesh or an image",
      path);
  run.line.without({"seed", "force", "dry_run"});
  run.line.example("validate copper");
  if (!run.parse()) return 0;
  Checks checks;
  const RunControl control = run.control("checking");
  checks.run([&] { check_path(path, checks, control); });
  if (checks.problems().empty()) check_record(path, checks);
  control.report(1.0);

  if (checks.problems().empty()) {
    run.report(Json{{"valid", true}, {"problems", Json::array()}}, path.string() + ": OK");
    return 0;
  }
  // As errors are: one line each on stderr.
  run.note_problems(checks.problems());
  if (run.line.common().json) run.report(Json{{"valid", false}, {"problems", checks.problems()}}, "");
  return 3;
}

}  // namespace patinate::cli
