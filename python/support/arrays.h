/// \file
/// Images and lists of vectors as numpy arrays. What we return moves into its array; what must not change is a
/// read-only view of our memory, which it keeps alive. What we are given is copied once: an image owns its values.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::python {

/// Shape of an image as an array: H x W, or H x W x C of more than one channel.
template <class T>
[[nodiscard]] std::vector<pybind11::ssize_t> shape_of(const Image<T>& image) {
  std::vector<pybind11::ssize_t> shape{image.height(), image.width()};
  if (image.channels() != 1) shape.push_back(image.channels());
  return shape;
}

/// The image's own memory as an array that may be written. No copy.
template <class T>
[[nodiscard]] pybind11::array array_of(Image<T>&& image) {
  auto kept = std::make_unique<Image<T>>(std::move(image));
  Image<T>* const pixels = kept.get();
  const pybind11::capsule owner(kept.release(), [](void* p) { delete static_cast<Image<T>*>(p); });
  return pybind11::array_t<T>(shape_of(*pixels), pixels->data(), owner);
}

/// A mask's memory as an array of bool, H x W, that may be written. No copy.
[[nodiscard]] pybind11::array mask_array(ImageU8&& mask);

/// Memory of ours as an array that cannot be written. @param owner  Keeps it alive.
template <class T>
[[nodiscard]] pybind11::array read_only(const T* values, std::vector<pybind11::ssize_t> shape, pybind11::handle owner) {
  pybind11::array_t<T> out(std::move(shape), values, owner);
  out.attr("flags").attr("writeable") = false;
  return out;
}
template <class T>
[[nodiscard]] pybind11::array read_only(const Image<T>& image, pybind11::handle owner) {
  return read_only(image.data(), shape_of(image), owner);
}

/// Arrays of one shape as one, with a new first axis; an empty list gives an array without elements.
[[nodiscard]] pybind11::object stacked(const pybind11::list& arrays);

/// A copy of numbers, in one dimension.
template <class T>
[[nodiscard]] pybind11::array array_of(const std::vector<T>& values) {
  return pybind11::array_t<T>(static_cast<pybind11::ssize_t>(values.size()), values.data());
}

/// Floats from an array of floats, H x W or H x W x C, of any layout. @param what  What messages call it.
/// @param channels  0 = any from 1 to 4. @throws InvalidInput on another shape, more than 65536 a side, or integers,
/// whose scale nobody knows.
[[nodiscard]] ImageF image_from(const pybind11::object& array, const std::string& what, int channels);
/// 0 / 255 from an array of bool or integers, H x W. @throws InvalidInput
[[nodiscard]] ImageU8 mask_from(const pybind11::object& array, const std::string& what);
/// Codes from an array of uint8, H x W x C. @throws InvalidInput
[[nodiscard]] ImageU8 codes_from(const pybind11::object& array, const std::string& what);
/// Nothing for None.
[[nodiscard]] ImageU8 optional_mask(const pybind11::object& array, const std::string& what);

/// Rows of numbers, N x columns, of any layout, as doubles. @throws InvalidInput
[[nodiscard]] pybind11::array_t<double> rows_from(const pybind11::object& array, const std::string& what, int columns);
/// Rows as int32. @throws InvalidInput also where a value does not fit.
[[nodiscard]] pybind11::array_t<std::int32_t> index_rows_from(const pybind11::object& array, const std::string& what,
                                                              int columns);
/// Numbers in one dimension, finite. @throws InvalidInput
[[nodiscard]] std::vector<double> numbers_from(const pybind11::object& array, const std::string& what);
/// Three of them. @throws InvalidInput
[[nodiscard]] Vec3 vector_from(const pybind11::handle& array, const std::string& what);

}  // namespace patinate::python
