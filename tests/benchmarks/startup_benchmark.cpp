// Prints what a start costs: wall-clock medians of commands that hardly work, and their ratio to a program that does
// nothing and to one that links what the modules hold; no test, no threshold.
//     build/release/bin/startup_benchmark
// Both programs are those that lie beside this one.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/benchmarks/timing.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;

/// Runs a program, its output nowhere. @returns its exit code, -1 if it has none.
int run(const fs::path& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  pid_t child = -1;
  const int error = ::posix_spawn(&child, program.c_str(), &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (error != 0 || ::waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

void require(int code, const std::string& what) {
  if (code == 0) return;
  std::fprintf(stderr, "startup_benchmark: %s: exit code %d\n", what.c_str(), code);
  std::exit(1);
}

/// Median of seven, the files in memory.
double start_seconds(const fs::path& program, const std::vector<std::string>& arguments) {
  (void)run(program, arguments);
  std::array<double, 7> times{};
  for (double& t : times) t = benchmarks::seconds([&] { (void)run(program, arguments); });
  std::sort(times.begin(), times.end());
  return times[3];
}

void print_starts() {
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path patinate = programs / "patinate";
  const testing_support::TempFolder folder;
  const auto in = [&](const char* name) { return (folder / name).string(); };
  const std::vector<std::vector<std::string>> preparations{
      {"synth", "crackle", "--width", "96", "--height", "96", "--num-frames", "3", "-o", in("capture")},
      {"synth", "sculpture", "--resolution", "24", "-o", in("urn")},
      {"ingest", in("capture"), "-o", in("history")},
      {"transfer", in("history"), in("urn/mesh.obj"), "--control", "thickness=facing", "--resolution", "64", "-o",
       in("aged")},
      {"lookup", in("aged"), "--time", "1", "-o", in("frame.tif")}};
  for (const std::vector<std::string>& arguments : preparations) require(run(patinate, arguments), arguments.front());

  const double nothing = start_seconds("/bin/true", {});
  const double linked = start_seconds(programs / "patinate-decode", {});  // Says how it is used, and ends.
  std::printf("%-34s %8s %18s %24s\n", "", "ms", "of /bin/true", "of a program that links");
  const auto print = [&](const char* name, double seconds) {
    std::printf("%-34s %8.1f %18.1f %24.2f\n", name, 1e3 * seconds, seconds / nothing, seconds / linked);
  };
  print("/bin/true", nothing);
  print("patinate-decode, which links all", linked);
  print("patinate --help", start_seconds(patinate, {"--help"}));
  print("patinate info, history", start_seconds(patinate, {"info", in("history")}));
  print("patinate lookup, 64 x 64, .png",
        start_seconds(patinate, {"lookup", in("aged"), "--time", "1", "--force", "-o", in("frame.png")}));
  print("patinate info, .tif (module)", start_seconds(patinate, {"info", in("frame.tif")}));
}

}  // namespace
}  // namespace patinate

int main() { patinate::print_starts(); }
