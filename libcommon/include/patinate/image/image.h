/// \file
/// Owning images and strided views of them: x right, y down, channels interleaved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace patinate {

/// H x W x C image that owns its values. Value semantics.
template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels = 1, T value = T{})
      : width_(width),
        height_(height),
        channels_(channels),
        values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels),
                value) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int channels() const { return channels_; }
  [[nodiscard]] bool empty() const { return values_.empty(); }
  [[nodiscard]] std::int64_t num_pixels() const { return std::int64_t{width_} * height_; }
  [[nodiscard]] bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  /// Width and height equal; channels may differ.
  template <class U>
  [[nodiscard]] bool same_size(const Image<U>& other) const {
    return width_ == other.width() && height_ == other.height();
  }

  [[nodiscard]] T& at(int x, int y, int c = 0) { return values_[index(x, y, c)]; }
  [[nodiscard]] const T& at(int x, int y, int c = 0) const { return values_[index(x, y, c)]; }
  /// The channels of one pixel.
  [[nodiscard]] std::span<T> pixel(int x, int y) {
    return {&values_[index(x, y, 0)], static_cast<std::size_t>(channels_)};
  }
  [[nodiscard]] std::span<const T> pixel(int x, int y) const {
    return {&values_[index(x, y, 0)], static_cast<std::size_t>(channels_)};
  }
  [[nodiscard]] std::span<T> row(int y) { return {data() + index(0, y, 0), row_size()}; }
  [[nodiscard]] std::span<const T> row(int y) const { return {data() + index(0, y, 0), row_size()}; }
  /// All values, row by row.
  [[nodiscard]] std::span<T> values() { return values_; }
  [[nodiscard]] std::span<const T> values() const { return values_; }
  [[nodiscard]] T* data() { return values_.data(); }
  [[nodiscard]] const T* data() const { return values_.data(); }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  [[nodiscard]] std::size_t row_size() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(channels_);
  }
  [[nodiscard]] std::size_t index(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels_) +
           static_cast<std::size_t>(c);
  }
  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<T> values_;
};

using ImageF = Image<float>;
using ImageU8 = Image<std::uint8_t>;
using ImageU16 = Image<std::uint16_t>;

/// A mask covers a pixel when it is empty (everything) or not 0 there.
[[nodiscard]] inline bool is_inside(const ImageU8& mask, int x, int y) { return mask.empty() || mask.at(x, y) != 0; }

}  // namespace patinate
