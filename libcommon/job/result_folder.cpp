#include "libcommon/job/result_folder.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace patinate {

namespace fs = std::filesystem;

namespace {

struct Manifest {
  std::string_view file;
  std::string_view
      says;  ///< Words of its first lines: "unlight.json" and "report.json" may be something else, of the user's.
};
constexpr std::array kManifests{Manifest{"history.json", "patinate.history"},
                                Manifest{"transfer.json", "patinate.transfer"},
                                Manifest{"simulation.json", "patinate.simulation"},
                                Manifest{"registration.json", "patinate.registration"},
                                Manifest{"unlight.json", "patinate.unlit"},
                                Manifest{"recomposed.json", "patinate.recomposed"},
                                Manifest{"sequence.json", "time_unit"},
                                Manifest{"factorization.json", "patinate.factorization"},
                                Manifest{"evaluation.json", "patinate.evaluation"},
                                Manifest{"report.json", "patinate.fit"},
                                Manifest{"report.json", "patinate.compare"}};

bool says(const fs::path& file, std::string_view word) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return false;
  std::ifstream in(file, std::ios::binary);
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(std::max<std::streamsize>(0, in.gcount()));
  return head.find('"' + std::string(word) + '"') != std::string::npos;
}

}  // namespace

fs::path result_around(fs::path folder) {
  for (; !folder.empty(); folder = folder.parent_path()) {
    const bool is_result = folder.extension() == ".partial" ||
                           std::any_of(kManifests.begin(), kManifests.end(), [&](const Manifest& manifest) {
                             return says(folder / manifest.file, manifest.says);
                           });
    if (is_result) return folder;
    if (folder == folder.root_path()) break;
  }
  return {};
}

}  // namespace patinate
