#include "tools/patinate/info/path_actions.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "analysis/explanation/explanation_report.h"
#include "analysis/factorization/factorization_document.h"
#include "analysis/fit/fit_job.h"
#include "app/request/failure.h"
#include "app/request/path_kind.h"
#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "libcommon/core/files.h"
#include "libcommon/history/history_card.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "simulation/job/simulation_job.h"
#include "tools/patinate/info/capture_results.h"
#include "tools/patinate/info/path_facts.h"

namespace patinate::cli {

namespace {

/// Reads every pixel that the history names.
void check_history(const std::filesystem::path& path, Checks& checks, const RunControl& control) {
  const HistoryReader history(path);
  for (int i = 0; i < history.num_frames(); ++i) {
    control.throw_if_stopped();
    checks.run([&] { (void)history.read_frame(i); });
    for (const std::string& name : history.facts().frames[i].extras)
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
void check_fixed(const capture::CaptureProject& project, Checks& checks, const RunControl& control) {
  double num_done = 0.0;
  for (const capture::CapturePhoto& frame : project.frames) {
    control.throw_if_stopped();
    checks.run([&] {
      // Each photograph of a hand-held series has a size of its own.
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

void check_capture_project(const std::filesystem::path& path, Checks& checks, const RunControl& control) {
  const std::filesystem::path file = capture::capture_file(path);
  if (capture::is_relit_capture(file)) return check_relit(capture::read_relit_project(file), checks, control);
  check_fixed(capture::read_capture_project(file), checks, control);
}

void check_transfer(const std::filesystem::path& path, Checks& checks, const RunControl& control) {
  const transfer::TransferReader transfer(path);
  check_history(transfer.history().folder(), checks, control);
}

void check_simulation(const std::filesystem::path& path, Checks& checks, const RunControl& control) {
  const std::filesystem::path folder = manifest_folder(path, "simulation.json");
  const simulation::SimulationManifest m = simulation::read_simulation_manifest(path);
  std::vector<std::string> channels;
  for (const std::string& material : m.materials) channels.push_back("amount." + material);
  checks.run([&] { (void)read_channels(folder / "atlas.exr", channels); });
  for (const char* name : {"color.png", "normal.png", "specular.png"})
    checks.run([&] { (void)read_color(folder / name); });
  checks.run([&] { (void)read_gray(folder / "height.exr"); });
  checks.run([&] { (void)read_mesh(folder / "model.glb"); });
  for (const std::string& name : m.control_names())
    checks.run([&] { (void)read_gray(folder / "controls" / (name + ".exr")); });
  check_history(folder / "history", checks, control);
}

void check_factorization(const std::filesystem::path& path, Checks& checks, const RunControl& control) {
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
  check_history(m.history, checks, control);
}

void check_fit(const std::filesystem::path& path, Checks& checks, const RunControl& control) {
  const std::filesystem::path folder = manifest_folder(path, analysis::kFitReportFile);
  const std::size_t n = analysis::read_fit_manifest(path).num_captures();
  for (std::size_t c = 0; c < n; ++c) {
    const auto file = [&](const char* stem) { return folder / analysis::file_of_capture(n, stem, c); };
    checks.run([&] { (void)simulation::read_scene(file("scene").string() + ".json", control); });
    checks.run([&] { check_history(file("before"), checks, control); });
    checks.run([&] { check_history(file("after"), checks, control); });
  }
}

void check_explanation(const std::filesystem::path& path, Checks& checks, const RunControl&) {
  const std::filesystem::path folder = manifest_folder(path, analysis::kExplanationFile);
  (void)analysis::read_explanation(path);
  for (const char* name : {analysis::kExplanationTableFile, analysis::kExplanationPageFile})
    checks.run([&] { (void)read_file(folder / name); });
}

void check_mesh(const std::filesystem::path& path, Checks& checks, const RunControl&) {
  checks.run([&] { (void)read_mesh(path); });
}

void check_image(const std::filesystem::path& path, Checks& checks, const RunControl&) {
  checks.run([&] { (void)read_color(path); });
}

/// A check that ends with the first thing that is wrong.
template <void (*check)(const std::filesystem::path&)>
void alone(const std::filesystem::path& path, Checks&, const RunControl&) {
  check(path);
}

/// Facts that are told of a kind, and checks.
struct PathActions {
  app::PathKind kind;
  Facts (*facts)(const std::filesystem::path&);
  void (*check)(const std::filesystem::path&, Checks&, const RunControl&);
};

constexpr std::array kActions{
    PathActions{app::PathKind::History, history_facts, check_history},
    PathActions{app::PathKind::Transfer, transfer_facts, check_transfer},
    PathActions{app::PathKind::Capture, capture_facts, check_capture_project},
    PathActions{app::PathKind::Simulation, simulation_facts, check_simulation},
    PathActions{app::PathKind::Registration, registration_facts, alone<check_registration>},
    PathActions{app::PathKind::Unlit, unlit_facts, alone<check_unlit>},
    PathActions{app::PathKind::Calibration, calibration_facts, alone<check_calibration>},
    PathActions{app::PathKind::Factorization, factorization_facts, check_factorization},
    PathActions{app::PathKind::Fit, fit_facts, check_fit},
    PathActions{app::PathKind::Explanation, explanation_facts, check_explanation},
    PathActions{app::PathKind::Report, report_facts, alone<check_report>},
    PathActions{app::PathKind::Mesh, mesh_facts, check_mesh},
    PathActions{app::PathKind::Image, image_facts, check_image},
};

const PathActions& actions_of(const std::filesystem::path& path) {
  return *std::find_if(kActions.begin(), kActions.end(),
                       [kind = app::kind_of(path)](const PathActions& a) { return a.kind == kind; });
}

}  // namespace

void Checks::run(const std::function<void()>& check) {
  try {
    check();
  } catch (const InputError& e) {
    problems_.emplace_back(e.what());
  }
}

Facts facts_of(const std::filesystem::path& path) try { return actions_of(path).facts(path); } catch (...) {
  app::rethrow_naming(path);
}

void check_path(const std::filesystem::path& path, Checks& checks, const RunControl& control) try {
  actions_of(path).check(path, checks, control);
} catch (...) {
  app::rethrow_naming(path);
}

std::string path_kinds_text() {
  return "A history, capture, transfer, simulation, fit, registration, unlit, factorization, explanation, "
         "comparison, grade or evaluation folder, a "
         "calibration, a mesh or an image";
}

}  // namespace patinate::cli
