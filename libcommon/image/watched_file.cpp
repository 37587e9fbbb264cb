#include "libcommon/image/watched_file.h"

#include <OpenImageIO/filesystem.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace patinate {

class WatchedFile::Proxy : public OIIO::Filesystem::IOProxy {
 public:
  explicit Proxy(const std::filesystem::path& path)
      : IOProxy(path.string(), Write), file_(std::fopen(path.c_str(), "wb")) {
    if (file_ == nullptr) has_failed_ = true;
  }
  ~Proxy() override { Proxy::close(); }
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  [[nodiscard]] const char* proxytype() const override { return "patinate"; }
  void close() override {
    if (file_ != nullptr && std::fclose(file_) != 0) has_failed_ = true;
    file_ = nullptr;
  }
  bool seek(std::int64_t offset) override {
    m_pos = offset;
    return true;
  }
  std::size_t write(const void* bytes, std::size_t size) override {
    const std::size_t written = pwrite(bytes, size, m_pos);
    m_pos += static_cast<std::int64_t>(written);
    return written;
  }
  std::size_t pwrite(const void* bytes, std::size_t size, std::int64_t offset) override {
    has_failed_ = has_failed_ || file_ == nullptr || (offset != at_ && ::fseeko(file_, offset, SEEK_SET) != 0) ||
                  std::fwrite(bytes, 1, size, file_) != size;
    at_ = offset + static_cast<std::int64_t>(size);
    size_ = std::max(size_, at_);
    return size;
  }
  [[nodiscard]] std::size_t size() const override { return static_cast<std::size_t>(size_); }
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  std::FILE* file_;
  std::int64_t at_ = 0, size_ = 0;
  bool has_failed_ = false;
};

WatchedFile::WatchedFile(const std::filesystem::path& path) : proxy_(std::make_unique<Proxy>(path)) {}
WatchedFile::~WatchedFile() = default;

void* WatchedFile::proxy() { return static_cast<OIIO::Filesystem::IOProxy*>(proxy_.get()); }
void WatchedFile::close() { proxy_->close(); }
bool WatchedFile::has_failed() const { return proxy_->has_failed(); }

}  // namespace patinate
