// How far histories of the synthetic mold are from its truth, with one disturbance at a time and with all, and what the
// ingest costs.
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "capture/relit/relit_ingest.h"
#include "datasets_synthetic/mold_io.h"
#include "tests/benchmarks/capture/capture_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/mold_errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::benchmarks {

void measure_relit() {
  struct Case {
    const char* name;
    std::function<void(datasets::MoldOptions&)> disturb;
    capture::SpecularMode specular = capture::SpecularMode::Auto;
  };
  const datasets::MoldOptions all;
  const std::vector<Case> cases{
      {"nothing disturbs", [](datasets::MoldOptions&) {}},
      {"scanner's noise", [&](datasets::MoldOptions& o) { o.scan_noise_mm = all.scan_noise_mm; }},
      {"8-bit photographs with noise", [&](datasets::MoldOptions& o) { o.noise = all.noise; }},
      {"motion", [&](datasets::MoldOptions& o) { o.motion_deg = all.motion_deg, o.motion_mm = all.motion_mm; }},
      {"cast shadows", [&](datasets::MoldOptions& o) { o.shadows = true; }},
      {"highlights", [&](datasets::MoldOptions& o) { o.highlights = all.highlights; }},
      {"ambient light and drift", [&](datasets::MoldOptions& o) { o.ambient = all.ambient, o.drift = all.drift; }},
      {"everything", [&](datasets::MoldOptions& o) { o = all; }},
      {"everything, highlights rejected", [&](datasets::MoldOptions& o) { o = all; }, capture::SpecularMode::None},
      {"everything, highlights subtracted", [&](datasets::MoldOptions& o) { o = all; }, capture::SpecularMode::Fit},
      {"everything, poses given", [&](datasets::MoldOptions& o) { o = all, o.transforms = true; },
       capture::SpecularMode::None},
      {"everything, 10 lights", [&](datasets::MoldOptions& o) { o = all, o.num_lights = 10; }},
  };
  std::printf("%-32s %8s %8s %8s %8s %8s | %9s %9s %9s | %6s %7s\n", "albedo, relative error in %", "RMS", "median",
              "p95", "worst", "valid", "spot", "texel", "pose um", "normal", "ingest");
  for (const Case& c : cases) {
    datasets::MoldOptions options;
    options.exact = true;
    options = datasets::checked_mold(options);
    options.exact = false;
    c.disturb(options);
    const testing_support::TempFolder folder;
    run_job(datasets::plan_mold(options, folder / "mold"), {}, {});
    capture::RelitOptions ingest_options;
    ingest_options.unlight.specular = c.specular;
    const double s = seconds([&] {
      run_job(capture::plan_relit_ingest(capture::read_relit_project(folder / "mold/capture.json"), ingest_options,
                                         folder / "history"),
              {}, {});
    });
    const testing_support::MoldErrors e = testing_support::mold_errors(folder / "mold", folder / "history");
    std::printf(
        "%-32s %8.3f %8.3f %8.3f %8.2f %8.1f | %9.4f %9.4f %9.3f | %6.2f %5.1f s  rank correlation of accessibility "
        "%.3f\n",
        c.name, 100 * e.albedo_rms, 100 * e.albedo_median, 100 * e.albedo_p95, 100 * e.albedo_worst,
        100 * e.valid_share, 100 * e.spot_drift, 100 * e.spot_texel_drift, 1000 * e.pose_mm, e.normal_median_deg, s,
        e.accessibility_correlation);
    std::fflush(stdout);
  }
}

}  // namespace patinate::benchmarks
