#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/device/checked_devices.h"
#include "app/request/history_library.h"
#include "app/request/output_file.h"
#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"
#include "libcommon/core/user_cache.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/interruption.h"
#include "tools/patinate/command_line/option_sources.h"
#include "tools/patinate/command_line/studio_job.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/studio_commands.h"
#include "tools/studio/access.h"
#include "tools/studio/recording.h"
#include "tools/studio/server.h"
#include "tools/studio/session.h"
#include "tools/studio/studio.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds kLongestEnd{
    10};  ///< An iteration of a large scene ends, and what was painted last is written.

struct StudioPort {
  int port = 0;
};
void describe(OptionVisitor& v, StudioPort& o) {
  v.visit({"port", "Port to listen on; 0 = any that is free", "", between(0, 65535)}, o.port);
}

std::string this_machine() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0' ? name.data() : "HOST";
}

/// A page instead of a server.
struct SessionArgument {
  fs::path file;
  std::string place;
  std::vector<double> times;
  std::optional<double> size;

  void declare(CommandLine& line) {
    line.option("save", "FILE.html", "Write a place as one page that opens without a server, and end", file);
    line.written();
    line.option(
        "place", "PLACE",
        "With --save: a history, transfer or simulation, by its name below the folder; default: the folder itself",
        place);
    line.numbers("times", "T,T,...", "With --save: times whose textures are in the page; default: those of the frames",
                 times);
    line.option("size", "N", "With --save: longest side of a texture, [16, 8192] texels; default 1024", size);
  }
  [[nodiscard]] bool is_given() const { return !file.empty(); }
};

int save_session(CommandRun& run, const fs::path& folder, const SessionArgument& argument) {
  app::require_extension(argument.file, {".html"});
  studio::SessionOptions options;
  options.place = argument.place.empty() ? "." : argument.place;
  options.times = argument.times;
  if (argument.size) {
    if (!(*argument.size >= 16 && *argument.size <= 8192) || *argument.size != std::floor(*argument.size))
      throw app::UsageError("--size: found `" + number_text(*argument.size) + "`; expected an integer [16, 8192]");
    options.size = static_cast<int>(*argument.size);
  }
  (void)run.check_file(argument.file, "", "page");
  studio::Studio studio(studio::ServedFolder(folder),
                        {.version = PATINATE_VERSION,
                         .token = {},
                         .port = 0,
                         .hosts = {},
                         .num_threads = run.line.common().threads,
                         .open_device = {}},
                        [] {});
  write_atomically(argument.file, studio.session(options, run.control("studio")));
  run.report_output(JobStatus::Done, argument.file);
  return 0;
}

std::vector<fs::path> existing_folders(std::vector<fs::path> folders) {
  std::error_code error;
  std::erase_if(folders, [&](const fs::path& folder) { return !fs::is_directory(folder, error); });
  return folders;
}

/// This program again, with the options of the command line alone. @param readable  The served folder first.
studio::JobProgram job_program(std::vector<fs::path> readable, std::vector<fs::path> libraries) {
  const std::string prefix = "PATINATE_";
  std::vector<std::string> environment;
  const Environment options = patinate_environment();
  for (char** entry = ::environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string text(*entry);
    const bool is_option = std::any_of(options.begin(), options.end(), [&](const auto& option) {
      return text.starts_with(prefix + option.first + "=");
    });
    if (!is_option) environment.push_back(text);
  }
  // What a history's analysis or a control's map took long for is kept where the command line keeps it.
  libraries.insert(libraries.begin(), readable.front());
  const fs::path cache = user_cache_folder();
  std::error_code error;
  fs::create_directories(cache, error);  // A job could not make it.
  if (fs::is_directory(cache, error)) {
    readable.push_back(cache);
    libraries.push_back(cache);
  }
  environment.push_back(std::string(kStudioJobVariable) + "=" +
                        studio_job_text({.read = std::move(readable), .written = std::move(libraries)}));
  return {.file = "/proc/self/exe", .environment = std::move(environment)};
}

void tell_address(CommandRun& run, int port, const std::string& token, const fs::path& recordings) {
  const std::string number = std::to_string(port), address = "http://127.0.0.1:" + number + "/?token=" + token;
  const std::string tunnel = "ssh -L " + number + ":127.0.0.1:" + number + " " + this_machine();
  const std::string kept =
      recordings.empty() ? "nowhere: the folder is a finished result, or part of one" : "in " + recordings.string();
  run.report(Json{{"address", address},
                  {"port", port},
                  {"token", token},
                  {"tunnel", tunnel},
                  {"recordings", recordings.empty() ? Json(nullptr) : Json(recordings.string())}},
             "Open        " + address + "\nElsewhere   " + tunnel + "   then open the same address there\n" +
                 (run.line.common().quiet ? "" : "Recorded    " + kept + "\n") + "End         Ctrl-C");
}

}  // namespace

int cmd_studio(CommandRun& run) {
  fs::path folder = ".";
  StudioPort port;
  device::DeviceOptions device;
  std::vector<std::string> hosts, also_read;
  SessionArgument session;
  run.line.positional("FOLDER",
                      "What to show: a folder with histories, transfers, simulations, scenes or captures, or one of "
                      "them; default: here",
                      folder);
  run.line.required(false);
  run.line.options(port);
  run.line.options(device);
  run.line.repeated("allow-host", "NAME",
                    "A name, without port, by which a browser may call this machine beside localhost", hosts);
  run.line.repeated("allow-folder", "FOLDER",
                    "A further folder to read, for files to which the shown ones refer, such as a transfer's history",
                    also_read);
  session.declare(run.line);
  run.line.without({"seed", "dry_run"});
  run.line.example("studio results");
  run.line.example("studio results --port 8080 --json");
  run.line.example("studio results --save aged.html --place aged --times 0,6,12");
  if (!run.parse()) return 0;
  std::error_code error;
  if (fs::is_regular_file(folder, error)) folder = folder_of(folder);
  if (session.is_given()) return save_session(run, folder, session);
  app::check_device(device);
  studio::ServedFolder served(folder);
  std::vector<fs::path> readable{served.path()};
  readable.insert(readable.end(), also_read.begin(), also_read.end());
  const std::vector<fs::path> libraries = existing_folders(app::library_folders());
  readable.insert(readable.end(), libraries.begin(), libraries.end());
  const fs::path recordings = studio::recording_folder(served);
  const ReadLimit limit(readable);  // also of what histories, scenes and meshes name
  studio::HttpServer server({.port = port.port});
  const std::string token = studio::random_token();
  bool has_quit = false;
  take_time_to_end(kLongestEnd);
  studio::Studio studio(std::move(served),
                        {.version = PATINATE_VERSION,
                         .token = token,
                         .port = server.port(),
                         .hosts = hosts,
                         .num_threads = run.line.common().threads,
                         .open_device = [&, say = words_of(run)] { return app::open_simulation_device(device, say); },
                         .commands = {studio_commands(), check_studio_command},
                         .program = job_program(readable, libraries)},
                        [&] {
                          has_quit = true;
                          server.stop();
                        });
  tell_address(run, server.port(), token, recordings);
  server.run({.admit = [&](const studio::HttpRequest& request) { return studio.admit(request); },
              .is_upload = studio::Studio::is_upload,
              .answer = [&](const studio::HttpRequest& request,
                            const std::stop_token& gone) { return studio.answer(request, gone); },
              .open = [&](const studio::HttpRequest& request,
                          const std::shared_ptr<studio::WebSocketPeer>& peer) { return studio.open(request, peer); }},
             run.control("studio").stop);
  return has_quit ? 0 : kInterruptedExitCode;
}

}  // namespace patinate::cli
