#include "libcommon/job/result_folder.h"

#include <algorithm>
#include <array>
#include <system_error>

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr std::array kManifests{"history.json", "transfer.json", "simulation.json", "registration.json", "unlight.json", "recomposed.json", "sequence.json",
                                "factorization.json", "evaluation.json", "evaluations.csv"};

}  // namespace

fs::path result_around(fs::path folder) {
  for (std::error_code error; !folder.empty(); folder = folder.parent_path()) {
    const bool is_result = folder.extension() == ".partial" ||
                           std::any_of(kManifests.begin(), kManifests.end(), [&](const char* manifest) { return fs::is_regular_file(folder / manifest, error); });
    if (is_result) return folder;
    if (folder == folder.root_path()) break;
  }
  return {};
}

}  // namespace patinate
