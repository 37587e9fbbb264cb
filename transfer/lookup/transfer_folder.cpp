#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/transfer_reader.h"

namespace patinate::transfer {

namespace {

/// With a history to read. @throws IoError that says what to do if it is not where it was.
TransferManifest usable_manifest(const std::filesystem::path& path) {
  TransferManifest manifest = read_transfer_manifest(path);
  std::error_code error;
  if (!std::filesystem::exists(manifest.history, error)) {
    const std::filesystem::path file = manifest_folder(path, "transfer.json") / "transfer.json";
    throw IoError(path.string(), "its history `" + manifest.history_name + "` is not at " + manifest.history.string() +
                                     "; put it there, or its place as `path` of `history` in " + file.string());
  }
  return manifest;
}

}  // namespace

TransferFolder::TransferFolder(const std::filesystem::path& path)
    : manifest_(usable_manifest(path)), history_(manifest_.history, manifest_.footprint_px), sheet_(manifest_.sheet()) {
  if (history_content_key(history_) != manifest_.history_key) {
    throw IoError(manifest_.history.string(),
                  "is not the history that " + path.string() + " was made from; make the transfer again");
  }
}

AtlasMesh TransferFolder::read_atlas() const {
  try {
    AtlasMesh atlas = read_back_atlas_mesh(with_normals(read_mesh(manifest_.mesh)), manifest_.tile_rule, sheet_.names);
    atlas.is_unwrapped = manifest_.is_unwrapped;
    return atlas;
  } catch (const InvalidInput& e) {
    throw IoError(manifest_.mesh.string(), e.what());
  }
}

}  // namespace patinate::transfer
