/// \file
/// Plain values and arrays as bytes, for snapshots. Little-endian machines only, as everything else here.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "patinate/core/error.h"

namespace patinate::simulation {

static_assert(std::endian::native == std::endian::little);

class ByteWriter {
 public:
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void value(const T& v) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&v);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof(T));
  }
  /// With its length. T has no padding.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void array(std::span<const T> values) {
    value(static_cast<std::uint64_t>(values.size()));
    const auto bytes = std::as_bytes(values);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  template <class T>
  void array(const std::vector<T>& values) {
    array(std::span<const T>(values));
  }
  void text(const std::string& s) { array(std::span<const char>(s.data(), s.size())); }

  [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Reads what ByteWriter wrote. @throws InvalidInput when there is less, or an array is longer than what is left.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void value(T& v) { std::memcpy(&v, take(sizeof(T)).data(), sizeof(T)); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  [[nodiscard]] T value() {
    T v;
    value(v);
    return v;
  }
  template <class T>
  void array(std::vector<T>& values) {
    const auto n = value<std::uint64_t>();
    if (n > rest_.size() / sizeof(T)) fail();
    values.resize(n);
    if (n > 0) std::memcpy(values.data(), take(values.size() * sizeof(T)).data(), values.size() * sizeof(T));
  }
  /// Into an array of the same length. @throws InvalidInput
  template <class T, std::size_t N>
  requires std::is_trivially_copyable_v<T>
  void fill(std::span<T, N> values) {
    if (value<std::uint64_t>() != values.size()) fail();
    if (!values.empty()) std::memcpy(values.data(), take(values.size_bytes()).data(), values.size_bytes());
  }
  [[nodiscard]] std::string text() {
    std::vector<char> letters;
    array(letters);
    return {letters.begin(), letters.end()};
  }
  /// @throws InvalidInput unless everything was read.
  void finish() const {
    if (!rest_.empty()) fail();
  }

 private:
  [[noreturn]] static void fail() { throw InvalidInput("the snapshot is damaged, or of another scene"); }
  std::span<const std::byte> take(std::size_t n) {
    if (n > rest_.size()) fail();
    const std::span<const std::byte> part = rest_.first(n);
    rest_ = rest_.subspan(n);
    return part;
  }
  std::span<const std::byte> rest_;
};

}  // namespace patinate::simulation
