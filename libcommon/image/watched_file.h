/// \file
/// A file for OpenImageIO's writers, some of which do not look whether a write failed.
#pragma once

#include <filesystem>
#include <memory>

namespace patinate {

/// A file that remembers that a write failed. Encoders are not told, since libpng would print a line of its own; who
/// writes asks has_failed().
class WatchedFile {
 public:
  explicit WatchedFile(const std::filesystem::path& path);
  ~WatchedFile();
  WatchedFile(const WatchedFile&) = delete;
  WatchedFile& operator=(const WatchedFile&) = delete;

  /// An OIIO::Filesystem::IOProxy, which lives as long as this; untyped, so that whoever includes this does not pay for
  /// that library.
  [[nodiscard]] void* proxy();
  void close();
  /// Say close() before, which may find it out.
  [[nodiscard]] bool has_failed() const;

 private:
  class Proxy;
  std::unique_ptr<Proxy> proxy_;
};

}  // namespace patinate
