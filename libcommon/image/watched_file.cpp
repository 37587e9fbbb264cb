#include "libcommon/image/watched_file.h"

namespace patinate {

WatchedFile::WatchedFile(const std::filesystem::path& path) : file_(std::fopen(path.c_str(), "wb")) {
  if (file_ == nullptr) has_failed_ = true;
}

WatchedFile::~WatchedFile() { close(); }

void WatchedFile::close() {
  if (file_ != nullptr && std::fclose(file_) != 0) has_failed_ = true;
  file_ = nullptr;
}

void WatchedFile::write(std::int64_t offset, const void* bytes, std::size_t size) {
  has_failed_ = has_failed_ || file_ == nullptr || (offset != at_ && ::fseeko(file_, offset, SEEK_SET) != 0) ||
                std::fwrite(bytes, 1, size, file_) != size;
  at_ = offset + static_cast<std::int64_t>(size);
}

}  // namespace patinate
