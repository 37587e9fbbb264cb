#include "transfer/library/library_parts.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/error.h"
#include "libcommon/core/json.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace {

constexpr double kMaxSide = 65536;

LibraryPart read_part(JsonReader json) {
  LibraryPart part;
  part.name = json.member("name").string();
  part.x = static_cast<int>(json.member("x").integer(between(0, kMaxSide)));
  part.width = static_cast<int>(json.member("width").integer(between(1, kMaxSide)));
  part.height = static_cast<int>(json.member("height").integer(between(1, kMaxSide)));
  part.key = json.member("key").string();
  json.finish();
  return part;
}

/// @throws InvalidInput
void check_parts(const HistoryManifest& m, const std::vector<LibraryPart>& parts) {
  if (parts.empty()) return;
  int begin = 0;
  for (const LibraryPart& part : parts) {
    if (part.x < begin || part.width < 1 || part.height < 1 || part.x > m.width - part.width || part.height > m.height) {
      throw InvalidInput("library: `" + part.name + "` lies outside of the history's " + size_text(m.width, m.height) + " pixels, or over the one before");
    }
    begin = part.x + part.width;
  }
  if (std::none_of(m.controls.begin(), m.controls.end(), [](const ControlParameter& c) { return c.name == kLibraryControl; })) {
    throw InvalidInput("library: the control `" + std::string(kLibraryControl) + "`, which says what a pixel belongs to, is missing");
  }
}

}  // namespace

std::vector<LibraryPart> library_parts(const HistoryReader& history) {
  const std::filesystem::path file = history.folder() / kHistoryManifestFile;
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  std::vector<LibraryPart> parts;
  if (!json.has("library")) return parts;
  const JsonReader list = json.member("library");
  for (const JsonReader& part : list.elements(kMaxLibraryParts)) parts.push_back(read_part(part));
  try {
    check_parts(history.manifest(), parts);
  } catch (const InvalidInput& e) {
    throw IoError(file.string(), e.what());
  }
  return parts;
}

void write_library_manifest(const std::filesystem::path& file, const HistoryManifest& manifest, const std::vector<LibraryPart>& parts) {
  check_parts(manifest, parts);
  write_history_manifest(file, manifest);
  Json json = load_json(file);
  for (const LibraryPart& part : parts) {
    json["library"].push_back({{"name", part.name}, {"x", part.x}, {"width", part.width}, {"height", part.height}, {"key", part.key}});
  }
  save_json(file, json);
}

}  // namespace patinate
