/// \file
/// The binary part of a GLB, on the disk while it grows: what stands before it in the file depends on its size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "libcommon/core/files.h"
#include "patinate/output/glb.h"

namespace patinate {

/// Pieces one after the other, each beginning at a multiple of 4.
class GlbBinary {
 public:
  /// Where a piece lies.
  struct View {
    std::uint64_t offset = 0, size = 0;
    int target = 0;  ///< Purpose of glTF's bufferView; 0 = none.
  };

  /// @param glb  The file to be: the pieces wait beside it, and are gone with this. @throws CannotComplete
  explicit GlbBinary(const std::filesystem::path& glb);
  ~GlbBinary();
  GlbBinary(const GlbBinary&) = delete;
  GlbBinary& operator=(const GlbBinary&) = delete;

  /// @returns its number. @throws CannotComplete if the disk is full.
  int add(const void* data, std::size_t size, int target = 0);
  template <class T>
  int add(const std::vector<T>& values, int target) {
    return add(values.data(), values.size() * sizeof(T), target);
  }
  /// Adds a PNG file. @throws InvalidInput if it makes fewer or more rows than it has.
  int add_png(const GlbTexture& texture, bool is_color);

  [[nodiscard]] const std::vector<View>& views() const { return views_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// All of it, and zeros up to a multiple of 4.
  void copy_to(std::ostream& out);

 private:
  void begin_piece();
  void append(const void* data, std::size_t size);
  [[noreturn]] void fail(const std::string& problem) const;

  std::string shown_path_;
  AtomicFile place_;  ///< Never finished: it is removed in the end.
  std::FILE* file_;
  std::uint64_t size_ = 0;
  std::vector<View> views_;
};

}  // namespace patinate
