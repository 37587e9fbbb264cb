#include "transfer/lookup/transfer_folder.h"

#include "libcommon/core/error.h"

namespace patinate {

TransferFolder::TransferFolder(const std::filesystem::path& path)
    : manifest_(read_transfer_manifest(path)), history_(manifest_.history), sheet_(manifest_.sheet()) {
  if (history_content_key(history_) != manifest_.history_key) {
    throw IoError(manifest_.history.string(), "is not the history that " + path.string() + " was made from; make the transfer again");
  }
}

}  // namespace patinate
