#include "tools/patinate/command_line/studio_job.h"

#include <signal.h>
#include <sys/prctl.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate::cli {

namespace fs = std::filesystem;

std::string studio_job_text(const StudioJobFolders& folders) {
  const auto texts = [](const std::vector<fs::path>& all) { return std::vector<std::string>(all.begin(), all.end()); };
  return Json{{"read", texts(folders.read)}, {"written", texts(folders.written)}}.dump(-1, ' ', false,
                                                                                       Json::error_handler_t::replace);
}

bool is_studio_job() { return std::getenv(kStudioJobVariable) != nullptr; }

StudioJob::StudioJob() {
  const char* text = std::getenv(kStudioJobVariable);
  if (text == nullptr) return;
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  try {
    const Json json = Json::parse(text);
    const auto folders = [&](const char* member) {
      const auto names = json.at(member).get<std::vector<std::string>>();
      if (names.empty()) throw InvalidInput(std::string(kStudioJobVariable) + ": names no folder");
      return std::vector<fs::path>(names.begin(), names.end());
    };
    read_.emplace(folders("read"));
    written_.emplace(folders("written"));
  } catch (const Json::exception& e) {
    throw InvalidInput(std::string(kStudioJobVariable) + ": is for commands that patinate studio starts; " + e.what());
  }
}

}  // namespace patinate::cli
