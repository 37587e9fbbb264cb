#include "tools/patinate/services/tile_files.h"

#include <nlohmann/json.hpp>

#include "patinate/atlas/sheet.h"
#include "tools/patinate/command_line/output_file.h"

namespace patinate::cli {

std::vector<std::filesystem::path> tile_files(const std::filesystem::path& output,
                                              const std::vector<std::string>& tile_names) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : tile_names) files.push_back(tile_path(output, name));
  return files;
}

std::optional<JobStatus> check_tile_files(CommandRun& run, const std::vector<std::filesystem::path>& files,
                                          const std::string& key) {
  // The one that decides: in the way, else missing, else any.
  const std::filesystem::path* decisive = &files.front();
  std::string decisive_key = image_file_key(files.front());
  const auto rank = [&](const std::filesystem::path& file, const std::string& existing) {
    std::error_code error;
    return !std::filesystem::exists(file, error) ? 1 : existing == key ? 0 : 2;
  };
  for (const std::filesystem::path& file : files) {
    const std::string existing = image_file_key(file);
    if (rank(file, existing) <= rank(*decisive, decisive_key)) continue;
    decisive = &file;
    decisive_key = existing;
  }
  return run.check_file(*decisive, decisive_key, key);
}

void report_tile_files(CommandRun& run, JobStatus status, const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& files, Json more) {
  if (files.size() == 1) return run.report_output(status, files.front(), more);
  Json names = Json::array();
  for (const std::filesystem::path& file : files) names.push_back(file.string());
  more["files"] = names;
  run.report_output(status, tile_path(output, "<UDIM>"), more);
}

}  // namespace patinate::cli
