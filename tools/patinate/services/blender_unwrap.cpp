#include "tools/patinate/services/blender_unwrap.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr double kMostSeconds = 600.0;
constexpr double kGutterTexels = 2.0;
constexpr double kSlack = 1e-3;  ///< By how much UVs may leave [0, 1], from rounding; they are brought back.
constexpr std::uint64_t kMostLogBytes = 1 << 20;

/// Builds the mesh from plain numbers, so that nothing is merged or put in another order, and writes (position, u, v)
/// per corner.
constexpr const char* kScript = R"(import sys
import bpy

source, target, margin = sys.argv[sys.argv.index("--") + 1:]
with open(source) as lines:
    num_positions, num_triangles = (int(word) for word in lines.readline().split())
    positions = [tuple(float(word) for word in lines.readline().split()) for _ in range(num_positions)]
    triangles = [tuple(int(word) for word in lines.readline().split()) for _ in range(num_triangles)]
for other in list(bpy.data.objects):  # The start-up cube would be packed too.
    bpy.data.objects.remove(other)
mesh = bpy.data.meshes.new("mesh")
mesh.from_pydata(positions, [], triangles)
thing = bpy.data.objects.new("mesh", mesh)
bpy.context.scene.collection.objects.link(thing)
bpy.context.view_layer.objects.active = thing
thing.select_set(True)
mesh.uv_layers.new()
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.select_all(action="SELECT")
bpy.ops.uv.smart_project(island_margin=float(margin))
bpy.context.scene.tool_settings.use_uv_select_sync = True
bpy.ops.uv.average_islands_scale()
bpy.ops.uv.pack_islands(rotate=True, margin=float(margin))
bpy.ops.object.mode_set(mode="OBJECT")
uvs = mesh.uv_layers.active.data
with open(target, "w") as out:
    print(len(mesh.polygons), file=out)
    for polygon in mesh.polygons:
        for corner in polygon.loop_indices:
            print(mesh.loops[corner].vertex_index, *uvs[corner].uv, file=out)
)";

[[noreturn]] void fail(const std::string& problem) {
  throw CannotComplete("blender: " + problem + "; --atlas unwrap needs no other program");
}

/// A folder of our own, removed in the end.
struct TemporaryFolder {
  fs::path path;
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "patinate-blender-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      fail(std::string("no temporary folder can be made for it, ") + std::strerror(errno));
    path = name;
  }
  ~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
};

/// At unit size around the origin: Blender counts in 32 bits.
void write_numbers(const fs::path& path, const Mesh& mesh) {
  const Box box = bounding_box(mesh);
  const double size = box.diagonal();
  const Vec3 center = box.center();
  std::string text = std::to_string(mesh.positions.size()) + " " + std::to_string(mesh.triangles.size()) + "\n";
  for (const Vec3& position : mesh.positions) {
    Vec3 p = (position - center) / size;
    if (!p.allFinite()) p = Vec3::Zero();
    text += number_text(p.x()) + " " + number_text(p.y()) + " " + number_text(p.z()) + "\n";
  }
  for (const Triangle& t : mesh.triangles) {
    text += std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  }
  write_atomically(path, text);
}

/// Blender in a process group of its own, so that it and what it starts can be ended together.
class Child {
 public:
  Child(std::vector<std::string> words, const fs::path& log) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int error = ::posix_spawnp(&pid_, arguments[0], &actions, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (error == 0) return;
    pid_ = -1;
    if (error == ENOENT) fail("is not installed, or not on the PATH");
    fail(std::string("cannot be started, ") + std::strerror(error));
  }
  ~Child() {
    if (pid_ < 0) return;
    ::kill(-pid_, SIGKILL);
    while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Its status as waitpid() tells it.
  int wait(const RunControl& control) {
    const auto begin = std::chrono::steady_clock::now();
    for (;;) {
      int status = 0;
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return status;
      }
      control.throw_if_stopped();
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      if (seconds > kMostSeconds) fail("did not finish within ten minutes");
      control.report(0.9 * seconds / (seconds + 10.0));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

 private:
  pid_t pid_ = -1;
};

/// The last line of what it said that speaks of an error; else its last line.
std::string reason_in(const fs::path& log) {
  std::istringstream lines;
  try {
    lines.str(read_file(log, kMostLogBytes));
  } catch (const IoError&) {
    return "";
  }
  std::string last, error;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line == "Blender quit") continue;
    last = line;
    if (line.find("Error") != std::string::npos) error = line;
  }
  return error.empty() ? last : error;
}

/// UVs equal at one position become one entry.
void read_uvs(const fs::path& path, Mesh& mesh) {
  std::ifstream in(path);
  std::size_t count = 0;
  if (!(in >> count)) fail("returned no UVs");
  if (count != mesh.triangles.size()) {
    fail("returned " + std::to_string(count) + " triangles of " + std::to_string(mesh.triangles.size()));
  }
  std::map<std::array<std::uint64_t, 3>, int> entries;
  std::vector<Vec2> uvs;
  std::vector<Triangle> uv_triangles(count);
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      int position = -1;
      Vec2 uv;
      if (!(in >> position >> uv.x() >> uv.y()) || position != mesh.triangles[t][k])
        fail("returned the triangles in another order");
      if (!(uv.minCoeff() >= -kSlack && uv.maxCoeff() <= 1.0 + kSlack)) fail("returned UVs outside [0, 1]");
      uv = uv.cwiseMax(0.0).cwiseMin(1.0);
      const std::array<std::uint64_t, 3> key{static_cast<std::uint64_t>(position), std::bit_cast<std::uint64_t>(uv.x()),
                                             std::bit_cast<std::uint64_t>(uv.y())};
      const auto [it, is_new] = entries.try_emplace(key, static_cast<int>(uvs.size()));
      if (is_new) uvs.push_back(uv);
      uv_triangles[t][k] = it->second;
    }
  }
  mesh.uvs = std::move(uvs);
  mesh.uv_triangles = std::move(uv_triangles);
}

}  // namespace

Mesh blender_unwrap(Mesh mesh, int resolution, const RunControl& control) {
  const TemporaryFolder folder;
  const fs::path script = folder.path / "unwrap.py", source = folder.path / "mesh.txt",
                 target = folder.path / "uvs.txt", log = folder.path / "log.txt";
  write_atomically(script, kScript);
  write_numbers(source, mesh);
  const std::string margin = std::to_string(kGutterTexels / resolution);
  Child blender({"blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python", script.string(),
                 "--", source.string(), target.string(), margin},
                log);
  const int status = blender.wait(control);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    const std::string reason = reason_in(log);
    fail("failed" + (reason.empty() ? std::string() : " (" + reason + ")"));
  }
  read_uvs(target, mesh);
  control.report(1.0);
  return mesh;
}

}  // namespace patinate::cli
