/// \file
/// What passes between a program and its `patinate-decode`: native integers through pipes. Inside of image input only.
///
/// The process first sends an answer with the ImageInfo; then, for every frame number (int32) it is sent, one with the
/// frame. An answer is `kAnswerOk` and its fields, or `kAnswerError` and one line of text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>

#include "libcommon/image/image_decoder.h"

namespace patinate {

inline constexpr std::uint32_t kAnswerOk = 0x4b4f5450;     // "PTOK"
inline constexpr std::uint32_t kAnswerError = 0x52455450;  // "PTER"
inline constexpr std::uint32_t kMaxWireText = 4096;

/// Moves exactly `size` bytes; throws what its maker wants when it cannot.
using WireRead = std::function<void(void* to, std::size_t size)>;
using WireWrite = std::function<void(const void* from, std::size_t size)>;

template <class T>
[[nodiscard]] T read_number(const WireRead& read) {
  static_assert(std::is_arithmetic_v<T>);
  T value{};
  read(&value, sizeof value);
  return value;
}
template <class T>
void write_number(const WireWrite& write, T value) {
  static_assert(std::is_arithmetic_v<T>);
  write(&value, sizeof value);
}

/// @throws InvalidInput where an answer breaks its bounds.
[[nodiscard]] std::string read_text(const WireRead& read);
void write_text(const WireWrite& write, const std::string& text);
[[nodiscard]] ImageInfo read_info(const WireRead& read);
void write_info(const WireWrite& write, const ImageInfo& info);
[[nodiscard]] CodedImage read_coded(const WireRead& read);
void write_coded(const WireWrite& write, const CodedImage& image);

}  // namespace patinate
