// Prints what unwrapping costs and how good its atlases are; no test, no threshold. Run it in a release build on a
// quiet machine:
//     PATINATE_DATA=... build/release/bin/unwrap_benchmark [MESH...]
// Medians of five runs, processor time; the ratio is over what Embree takes to build the mesh's ray scene.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>

#include "libcommon/geometry/ray_scene.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/atlas/unwrap.h"
#include "patinate/datasets/objects.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate {
namespace {

double median_of_five(const std::function<void()>& work) {
  std::array<double, 5> times{};
  for (double& t : times) {
    const std::clock_t begin = std::clock();
    work();
    t = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  }
  std::sort(times.begin(), times.end());
  return times[2];
}

void print_row(const std::string& name, Mesh mesh) {
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  UnwrapResult r;
  RunControl one_thread;
  one_thread.num_threads = 1;
  const double s = median_of_five([&] { r = unwrap(mesh, {}, one_thread); });
  const double scene_s = median_of_five([&] { const RayScene scene(mesh); });
  std::printf("| %-14s | %7d | %5d | %.3f | %.3f / %.3f / %.2f | %.3f / %.3f / %.2f | %.3f | %.2f | %.0f |",
              name.c_str(), mesh.num_triangles(), r.num_charts, r.packing, r.stretch.median, r.stretch.p95,
              r.stretch.max, r.angle_stretch.median, r.angle_stretch.p95, r.angle_stretch.max, r.l2_stretch, s,
              s / scene_s);
  for (int size : {1024, 2048}) {
    const TexelMap map(r.mesh, size, size);
    std::printf(" %.3f, %lld |", static_cast<double>(map.num_covered()) / static_cast<double>(map.num_texels()),
                static_cast<long long>(map.num_overlapping()));
  }
  std::printf("\n");
}

/// Edges are halved, longest first, until there are as many triangles.
Mesh refined_to(const Mesh& mesh, int num_triangles) {
  return refine_edges(mesh, 1e-9 * bounding_box(mesh).diagonal(), num_triangles);
}

}  // namespace
}  // namespace patinate

int main(int argc, char** argv) {
  using namespace patinate;
  std::printf(
      "| mesh | triangles | charts | packing | stretch median / p95 / max | angle median / p95 / max | L2 | time, s | "
      "over ray scene | covered, overlaps at 1024 | at 2048 |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (int i = 1; i < argc; ++i) print_row(std::filesystem::path(argv[i]).stem().string(), read_mesh(argv[i]));
  if (argc > 1) return 0;
  if (const char* data = std::getenv("PATINATE_DATA")) {
    const std::filesystem::path meshes = std::filesystem::path(data) / "meshes";
    const Mesh bust = read_mesh(meshes / "marble_bust" / "marble_bust_01_1k.gltf");
    print_row("blub", read_mesh(meshes / "blub" / "blub_triangulated.obj"));
    print_row("spot", read_mesh(meshes / "spot" / "spot_triangulated.obj"));
    print_row("bust", bust);
    print_row("hydrant", read_mesh(meshes / "fire_hydrant" / "fire_hydrant_1k.gltf"));
    print_row("bust, refined", refined_to(bust, 100'000));
  } else {
    std::printf("PATINATE_DATA is not set: only the synthetic urn\n");
  }
  print_row("urn", datasets::sculpture());
  datasets::SculptureOptions fine;
  fine.resolution = 98;
  print_row("urn, finer", datasets::sculpture(fine));
}
