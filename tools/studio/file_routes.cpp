// Routes to files on the disk: /api/places, /api/preview, /api/file.
#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/image/picture_bytes.h"
#include "tools/studio/preview.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

namespace {

struct FileType {
  std::string_view extension, type;
};
constexpr std::array kFileTypes{FileType{".json", "application/json"},
                                FileType{".csv", "text/csv; charset=utf-8"},
                                FileType{".html", "text/html; charset=utf-8"},
                                FileType{".txt", "text/plain; charset=utf-8"},
                                FileType{".png", "image/png"},
                                FileType{".jpg", "image/jpeg"},
                                FileType{".jpeg", "image/jpeg"},
                                FileType{".svg", "image/svg+xml"},
                                FileType{".glb", "model/gltf-binary"},
                                FileType{".exr", "image/x-exr"},
                                FileType{".ply", "application/octet-stream"},
                                FileType{".tif", "image/tiff"},
                                FileType{".gif", "image/gif"},
                                FileType{".mp4", "video/mp4"},
                                FileType{".webm", "video/webm"},
                                FileType{".usda", "text/plain; charset=utf-8"},
                                FileType{".usdz", "model/vnd.usdz+zip"},
                                FileType{".obj", "text/plain; charset=utf-8"}};
constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 30;
constexpr int kPreviewWidth = 1024, kMaxPreviewWidth = 8192;

}  // namespace

HttpResponse answer_places(const Asked& asked, const std::string& version) {
  Json places = Json::array();
  for (const PlaceEntry& entry : list_places(asked.folder)) {
    Json json{{"place", entry.place},
              {"kind", kPlaceKindNames[static_cast<std::size_t>(entry.kind)]},
              {"name", entry.name},
              {"detail", entry.detail},
              {"modified", entry.modified}};
    if (!entry.problem.empty()) json["problem"] = entry.problem;
    places.push_back(std::move(json));
  }
  return json_response(
      Json{{"folder", asked.folder.path().string()}, {"version", version}, {"places", std::move(places)}});
}

HttpResponse answer_preview(const Asked& asked) {
  const std::filesystem::path file = asked.file();
  const int width = asked.target.has("width") ? asked.integer("width", 1, kMaxPreviewWidth) : kPreviewWidth;
  std::optional<int> image;
  if (asked.target.has("image")) image = asked.integer("image", 0, std::numeric_limits<int>::max() - 1);
  return {.type = "image/jpeg", .body = jpeg_of(preview_of(file, width, image))};
}

HttpResponse answer_file(const Asked& asked) { return file_response(asked.file()); }

HttpResponse file_response(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  const auto found =
      std::find_if(kFileTypes.begin(), kFileTypes.end(), [&](const FileType& t) { return t.extension == extension; });
  if (found == kFileTypes.end())
    throw NotFound("files of this kind are not served; there are json, csv, html, txt, pictures, movies and models");
  // A page of the folder runs, but as a stranger to the studio: whoever wrote it cannot use the studio's cookie.
  return {.type = std::string(found->type),
          .headers = {{"Content-Security-Policy", "sandbox allow-scripts"}},
          .body = read_file(file, kMaxFileBytes)};
}

}  // namespace patinate::studio
