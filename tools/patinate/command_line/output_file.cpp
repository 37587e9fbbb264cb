#include "tools/patinate/command_line/output_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/usage_error.h"

namespace patinate::cli {

void require_extension(const std::filesystem::path& output, const std::vector<std::string>& extensions) {
  const std::string found = lower_extension(output);
  if (std::find(extensions.begin(), extensions.end(), found) != extensions.end()) return;
  std::string list;
  for (const std::string& e : extensions) list += (list.empty() ? "" : ", ") + e;
  throw UsageError("-o: found `" + output.string() + "`; expected a name that ends in " + list);
}

namespace {

/// Who names such a file does not mean a folder.
constexpr std::array<std::string_view, 34> kFiles{
    ".abc", ".avi",  ".bmp",  ".csv", ".dae", ".exr",  ".fbx",  ".gif",  ".glb",  ".gltf", ".html", ".jpeg",
    ".jpg", ".json", ".m4v",  ".mkv", ".mov", ".mp4",  ".obj",  ".pdf",  ".ply",  ".png",  ".stl",  ".svg",
    ".tif", ".tiff", ".toml", ".txt", ".usd", ".usda", ".usdc", ".usdz", ".webm", ".webp"};

/// "aged/", or a folder that is there: nothing to guess.
bool is_plainly_folder(const std::filesystem::path& output) {
  std::error_code error;
  return !output.has_filename() || std::filesystem::is_directory(output, error);
}

bool is_version(std::string_view suffix) {
  suffix.remove_prefix(suffix.starts_with(".v") ? 2 : 1);
  return std::all_of(suffix.begin(), suffix.end(), [](unsigned char c) { return std::isalpha(c) == 0; });
}

}  // namespace

void require_folder_name(const std::filesystem::path& output, const std::string& expected) {
  const std::string suffix = lower_extension(output);
  if (suffix.empty() || is_version(suffix) || is_plainly_folder(output)) return;
  throw UsageError("-o: found `" + output.string() + "`; expected " + expected);
}

void require_no_file_name(const std::filesystem::path& output) {
  if (is_plainly_folder(output) || std::find(kFiles.begin(), kFiles.end(), lower_extension(output)) == kFiles.end())
    return;
  const std::string plain = std::filesystem::path(output).replace_extension().string();
  throw UsageError("-o: found `" + output.string() +
                   "`, the name of a file; what is made is a folder: expected a name as `" + plain + "`");
}

const std::vector<std::string>& image_extensions() {
  static const std::vector<std::string> extensions{".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"};
  return extensions;
}

std::string image_file_key(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return "";
  try {
    return probe_image(path).key;
  } catch (const IoError&) {
    return "";  // there is a file, and it is none of ours
  }
}

}  // namespace patinate::cli
