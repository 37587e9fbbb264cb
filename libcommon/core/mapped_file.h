/// \file
/// Files looked at in place: only what is read of them takes memory, and the operating system may take that back.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <type_traits>

#include "patinate/core/error.h"

namespace patinate {

/// The bytes of a file, as they are as long as nobody writes it.
class MappedFile {
 public:
  /// @throws IoError if it cannot be read.
  explicit MappedFile(std::filesystem::path path);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  /// `count` values from `offset` bytes on. @throws IoError if the file is shorter.
  template <class T>
  [[nodiscard]] std::span<const T> values(std::size_t offset, std::size_t count) const {
    static_assert(std::is_trivially_copyable_v<T>);
    require(offset, count, sizeof(T));
    return {reinterpret_cast<const T*>(bytes_ + offset), count};
  }
  /// All of it. @throws IoError unless it holds whole values.
  template <class T>
  [[nodiscard]] std::span<const T> all() const {
    if (size_ % sizeof(T) != 0) fail();
    return values<T>(0, size_ / sizeof(T));
  }

 private:
  void require(std::size_t offset, std::size_t count, std::size_t size) const {
    if (offset > size_ || count > (size_ - offset) / size || offset % size != 0) fail();
  }
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  std::byte* bytes_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace patinate
