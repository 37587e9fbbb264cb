#include "tools/patinate/output_file.h"

#include <algorithm>
#include <cctype>

#include "libcommon/core/error.h"
#include "libcommon/image/image_io.h"

namespace patinate {

void require_extension(const std::filesystem::path& output, const std::vector<std::string>& extensions) {
  std::string found = output.extension().string();
  std::transform(found.begin(), found.end(), found.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(extensions.begin(), extensions.end(), found) != extensions.end()) return;
  std::string list;
  for (const std::string& e : extensions) list += (list.empty() ? "" : ", ") + e;
  throw UsageError("-o: found `" + output.string() + "`; expected a name that ends in " + list);
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

}  // namespace patinate
