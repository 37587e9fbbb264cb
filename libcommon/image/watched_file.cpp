#include "libcommon/image/watched_file.h"

#include <algorithm>

namespace patinate {

WatchedFile::WatchedFile(const std::filesystem::path& path) : IOProxy(path.string(), Write), file_(std::fopen(path.c_str(), "wb")) {
  if (file_ == nullptr) has_failed_ = true;
}

WatchedFile::~WatchedFile() { WatchedFile::close(); }

void WatchedFile::close() {
  if (file_ != nullptr && std::fclose(file_) != 0) has_failed_ = true;
  file_ = nullptr;
}

bool WatchedFile::seek(int64_t offset) {
  m_pos = offset;
  return true;
}

size_t WatchedFile::write(const void* bytes, size_t size) {
  const size_t written = pwrite(bytes, size, m_pos);
  m_pos += static_cast<int64_t>(written);
  return written;
}

size_t WatchedFile::pwrite(const void* bytes, size_t size, int64_t offset) {
  has_failed_ = has_failed_ || file_ == nullptr || (offset != at_ && ::fseeko(file_, offset, SEEK_SET) != 0) || std::fwrite(bytes, 1, size, file_) != size;
  at_ = offset + static_cast<int64_t>(size);
  size_ = std::max(size_, at_);
  return size;
}

}  // namespace patinate
