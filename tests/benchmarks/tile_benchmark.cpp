/// What a transfer by tile takes: each item in a process of its own, its processor time and the most memory it held.
/// tile_benchmark MESH.obj HISTORY RESOLUTION TEXEL_MM FOLDER [whole | here]: UVs of several tiles, millimeters;
/// control facing for the history's first control, without structure. With `whole` the transfer in one piece, with
/// `here` all items in one process.
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "libcommon/job/spread_job.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/history/history.h"
#include "patinate/mesh_files/mesh_io.h"
#include "transfer/job/transfer_job.h"
#include "transfer/tiles/tile_job.h"

using namespace patinate;

namespace {

struct Cost {
  int num_items = 0;
  double seconds = 0.0, megabytes = 0.0;
};

/// Calls `work` in a process of its own.
template <class Work>
Cost cost_of(const Work& work) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    try {
      work();
      std::_Exit(0);
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s\n", e.what());
      std::_Exit(1);
    }
  }
  int status = 0;
  rusage usage{};
  if (wait4(child, &status, 0, &usage) != child || status != 0) std::exit(1);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {1, seconds(usage.ru_utime) + seconds(usage.ru_stime), static_cast<double>(usage.ru_maxrss) * 1024e-6};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) {
    std::puts("tile_benchmark MESH.obj HISTORY RESOLUTION TEXEL_MM FOLDER [whole | here]: needs a mesh and a history");
    return 0;
  }
  mallopt(M_MMAP_THRESHOLD, 1 << 20);  // As the command does.
  const std::filesystem::path folder = argv[5];
  const std::string mode = argc > 6 ? argv[6] : "";
  transfer::TransferTask task;
  task.history = std::make_shared<const HistoryReader>(argv[2]);
  const Mesh mesh = read_mesh(argv[1]);
  task.atlas = std::make_shared<AtlasMesh>(atlas_mesh_of(mesh, find_uv_layout(mesh)));
  const Sheet sheet = make_sheet(task.atlas->tile_names(), std::atoi(argv[3]), Sheet::kMaxPartTexels);
  task.input.texel_size_mm = std::atof(argv[4]);
  task.options.appearance.structure = 0.0;
  task.mesh_name = "mesh.obj";
  const std::string source = task.history->facts().controls.front().name;
  const auto make_map = [&](TexelFinding finding) {
    task.input.map = std::make_shared<TexelMap>(sheet_mesh(*task.atlas, sheet), sheet, RunControl{}, finding);
    task.input.frames = std::make_shared<const FlowFrames>(
        direction_frames(*task.input.map, DirectionKind::Gravity, Vec3(0.0, 1.0, 0.0)));
  };
  RunControl one;
  one.num_threads = 1;
  if (mode == "whole") {
    const Cost cost = cost_of([&] {
      make_map(TexelFinding::AtOnce);
      ControlMap made = make_control_expression("facing", *task.input.map);
      task.input.controls.push_back({source,
                                     "facing",
                                     std::move(made.values),
                                     {made.low, made.high, made.unit},
                                     1.0,
                                     transfer::ControlMapping::Rank});
      (void)run_job(transfer::plan_transfer(task, folder), {.force = true}, one);
    });
    std::printf("whole: %.2f s, %.0f MB\n", cost.seconds, cost.megabytes);
    return 0;
  }
  make_map(TexelFinding::WhereLooked);
  task.input.controls.push_back({source, "facing", {}, {0.0, 1.0, "cosine"}, 1.0, transfer::ControlMapping::Rank});
  const auto make_plan = [&] { return transfer::plan_tiled_transfer({task, {}}, folder); };
  if (mode == "here") {
    const Cost cost = cost_of([&] { (void)run_job(make_plan(), {.force = true}, one); });
    std::printf("here: %.2f s, %.0f MB\n", cost.seconds, cost.megabytes);
    return 0;
  }
  const JobPlan plan = make_plan();
  std::map<std::string, Cost> stages;
  Cost all;
  for (std::size_t i = 0; i < plan.items.size(); ++i) {
    const Cost cost = cost_of([&] { (void)run_spread_items(make_plan(), std::array{i}, {}, one); });
    const std::string& name = plan.items[i].name;
    for (Cost* sum :
         {&stages[std::to_string(plan.items[i].stage + 100) + " " + name.substr(0, name.find('.'))], &all}) {
      ++sum->num_items;
      sum->seconds += cost.seconds;
      sum->megabytes = std::max(sum->megabytes, cost.megabytes);
    }
  }
  const Cost joined = cost_of([&] { (void)join_spread_items(make_plan(), {.force = true}, one); });
  for (const auto& [name, cost] : stages)
    std::printf("%-28s %4d items, %8.3f s each, at most %5.0f MB\n", name.c_str() + 4, cost.num_items,
                cost.seconds / cost.num_items, cost.megabytes);
  std::printf("join: %.2f s, %.0f MB\nall: %.2f s, at most %.0f MB\n", joined.seconds, joined.megabytes,
              all.seconds + joined.seconds, all.megabytes);
  return 0;
}
