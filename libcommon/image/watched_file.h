/// \file
/// A file that encoders write to, which do not look whether a write failed. Inside of output only.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>

#include "libcommon/image/image_source.h"

namespace patinate {

/// A file that remembers that a write failed; who writes asks has_failed().
class WatchedFile final : public ByteSink {
 public:
  explicit WatchedFile(const std::filesystem::path& path);
  ~WatchedFile() override;
  WatchedFile(const WatchedFile&) = delete;
  WatchedFile& operator=(const WatchedFile&) = delete;

  void write(std::int64_t offset, const void* bytes, std::size_t size) override;
  void close();
  /// Say close() before, which may find it out.
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  std::FILE* file_;
  std::int64_t at_ = 0;
  bool has_failed_ = false;
};

}  // namespace patinate
