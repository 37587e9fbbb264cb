#include "python/support/arrays.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "patinate/core/error.h"
#include "patinate/history/history_value.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

std::string text_of_shape(const py::array& array) {
  std::string text;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i == 0 ? "" : " x ") + std::to_string(array.shape(i));
  return array.ndim() == 0 ? "a single number" : text;
}

[[noreturn]] void refuse(const std::string& what, const py::array& array, const std::string& expected) {
  throw InvalidInput(what + ": found " + text_of_shape(array) + " of " + std::string(py::str(array.dtype())) +
                     "; expected " + expected);
}

py::array any_array(const py::object& given, const std::string& what) {
  py::array array = py::array::ensure(given);
  if (!array) throw InvalidInput(what + ": is no array");
  return array;
}

/// Height, width and channels.
template <class T>
Image<T> copied(const py::array_t<T, py::array::c_style | py::array::forcecast>& array) {
  const auto width = static_cast<int>(array.shape(1)), height = static_cast<int>(array.shape(0));
  Image<T> image(width, height, array.ndim() == 3 ? static_cast<int>(array.shape(2)) : 1);
  if (!image.values().empty()) std::memcpy(image.data(), array.data(), image.values().size_bytes());
  return image;
}

bool is_image_shape(const py::array& array, int channels) {
  if (array.ndim() != 2 && array.ndim() != 3) return false;
  for (int i = 0; i < 2; ++i) {
    if (array.shape(i) < 1 || array.shape(i) > kMaxHistorySide_px) return false;
  }
  const py::ssize_t found = array.ndim() == 3 ? array.shape(2) : 1;
  return channels == 0 ? found >= 1 && found <= 4 : found == channels;
}

std::string shape_text(int channels) {
  if (channels == 0) return "H x W, or H x W x 1 to 4";
  return channels == 1 ? "H x W" : "H x W x " + std::to_string(channels);
}

}  // namespace

ImageF image_from(const py::object& given, const std::string& what, int channels) {
  const py::array array = any_array(given, what);
  const char kind = array.dtype().kind();
  const bool is_float = kind == 'f';
  if (!is_float || !is_image_shape(array, channels)) {
    refuse(what, array,
           shape_text(channels) + " of floats" +
               (kind == 'u' || kind == 'i' ? " (linear_from_srgb() makes them of 8-bit codes)" : ""));
  }
  return copied<float>(py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(array));
}

py::object stacked(const py::list& arrays) {
  const py::module_ numpy = py::module_::import("numpy");
  return arrays.empty() ? numpy.attr("zeros")(0) : numpy.attr("stack")(arrays);
}

py::array mask_array(ImageU8&& mask) {
  for (std::uint8_t& m : mask.values()) m = m != 0 ? 1 : 0;  // numpy keeps its bools as 0 and 1.
  auto kept = std::make_unique<ImageU8>(std::move(mask));
  ImageU8* const pixels = kept.get();
  const py::capsule owner(kept.release(), [](void* p) { delete static_cast<ImageU8*>(p); });
  return py::array(py::dtype::of<bool>(), shape_of(*pixels), pixels->data(), owner);
}

ImageU8 mask_from(const py::object& given, const std::string& what) {
  const py::array array = any_array(given, what);
  const char kind = array.dtype().kind();
  if ((kind != 'b' && kind != 'u' && kind != 'i') || !is_image_shape(array, 1))
    refuse(what, array, "H x W of bool or integers");
  const auto inside = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(array);
  ImageU8 mask(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)));
  const bool* values = inside.data();
  for (std::uint8_t& m : mask.values()) m = *values++ ? 255 : 0;
  return mask;
}

ImageU8 codes_from(const py::object& given, const std::string& what) {
  const py::array array = any_array(given, what);
  if (!array.dtype().is(py::dtype::of<std::uint8_t>()) || !is_image_shape(array, 0))
    refuse(what, array, "H x W x 1 to 4 of uint8");
  return copied<std::uint8_t>(py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>::ensure(array));
}

ImageU8 optional_mask(const py::object& array, const std::string& what) {
  return array.is_none() ? ImageU8() : mask_from(array, what);
}

py::array_t<double> rows_from(const py::object& given, const std::string& what, int columns) {
  const py::array array = any_array(given, what);
  const char kind = array.dtype().kind();
  if ((kind != 'f' && kind != 'i' && kind != 'u') || array.ndim() != 2 || array.shape(1) != columns)
    refuse(what, array, "N x " + std::to_string(columns) + " of numbers");
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

py::array_t<std::int32_t> index_rows_from(const py::object& given, const std::string& what, int columns) {
  const py::array array = any_array(given, what);
  const char kind = array.dtype().kind();
  if ((kind != 'i' && kind != 'u') || array.ndim() != 2 || array.shape(1) != columns)
    refuse(what, array, "N x " + std::to_string(columns) + " of integers");
  const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    const std::int64_t value = wide.data()[i];
    if (value < std::numeric_limits<std::int32_t>::min() || value > std::numeric_limits<std::int32_t>::max())
      throw InvalidInput(what + ": holds " + std::to_string(value) + "; expected 32-bit indices");
  }
  return py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>::ensure(wide);
}

std::vector<double> numbers_from(const py::object& given, const std::string& what) {
  const py::array array = any_array(given, what);
  const char kind = array.dtype().kind();
  if ((kind != 'f' && kind != 'i' && kind != 'u') || array.ndim() != 1) refuse(what, array, "one dimension of numbers");
  const auto values = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  std::vector<double> out(values.data(), values.data() + values.size());
  for (const double v : out) {
    if (!std::isfinite(v)) throw InvalidInput(what + ": holds a value that is not finite");
  }
  return out;
}

Vec3 vector_from(const py::handle& given, const std::string& what) {
  const std::vector<double> numbers = numbers_from(py::reinterpret_borrow<py::object>(given), what);
  if (numbers.size() != 3)
    throw InvalidInput(what + ": has " + std::to_string(numbers.size()) + " numbers; expected 3");
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace patinate::python
