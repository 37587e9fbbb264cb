/// \file
/// Numbers in the bytes of a file, within bounds. Inside of image input only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace patinate {

/// Bytes that are not trusted: what lies beyond the end reads as 0, as "" or as nothing.
class FileBytes {
 public:
  explicit FileBytes(std::span<const unsigned char> bytes, bool is_little = false)
      : bytes_(bytes), is_little_(is_little) {}

  [[nodiscard]] std::uint64_t size() const { return bytes_.size(); }
  [[nodiscard]] bool is_little() const { return is_little_; }
  [[nodiscard]] bool holds(std::uint64_t at, std::uint64_t count) const {
    return at <= bytes_.size() && count <= bytes_.size() - at;
  }
  /// @param width  Bytes, [1, 8].
  [[nodiscard]] std::uint64_t number(std::uint64_t at, unsigned width) const {
    if (!holds(at, width)) return 0;
    std::uint64_t value = 0;
    for (unsigned i = 0; i < width; ++i) value = value << 8 | bytes_[at + (is_little_ ? width - 1 - i : i)];
    return value;
  }
  [[nodiscard]] std::string_view text(std::uint64_t at, std::uint64_t count) const {
    if (!holds(at, count)) return {};
    return {reinterpret_cast<const char*>(bytes_.data()) + at, static_cast<std::size_t>(count)};
  }
  /// The part, as far as it is there.
  [[nodiscard]] std::span<const unsigned char> part(std::uint64_t at, std::uint64_t count) const {
    if (at >= bytes_.size()) return {};
    return bytes_.subspan(at, static_cast<std::size_t>(count < bytes_.size() - at ? count : bytes_.size() - at));
  }
  [[nodiscard]] bool starts_with(std::string_view magic, std::uint64_t at = 0) const {
    return text(at, magic.size()) == magic && !magic.empty();
  }

 private:
  std::span<const unsigned char> bytes_;
  bool is_little_;
};

}  // namespace patinate
