/// \file
/// A file for OpenImageIO's writers, some of which do not look whether a write failed. Inside of output only.
#pragma once

#include <OpenImageIO/filesystem.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>

namespace patinate {

/// A file that remembers that a write failed. Encoders are not told, since libpng would print a line of its own; who writes asks has_failed().
class WatchedFile : public OIIO::Filesystem::IOProxy {
 public:
  explicit WatchedFile(const std::filesystem::path& path);
  ~WatchedFile() override;
  WatchedFile(const WatchedFile&) = delete;
  WatchedFile& operator=(const WatchedFile&) = delete;

  [[nodiscard]] const char* proxytype() const override { return "patinate"; }
  void close() override;
  bool seek(int64_t offset) override;
  size_t write(const void* bytes, size_t size) override;
  size_t pwrite(const void* bytes, size_t size, int64_t offset) override;
  [[nodiscard]] size_t size() const override { return static_cast<size_t>(size_); }
  /// Say close() before, which may find it out.
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  std::FILE* file_;
  int64_t at_ = 0, size_ = 0;
  bool has_failed_ = false;
};

}  // namespace patinate
