#include <utility>

#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

void bind_images(py::module_& module) {
  define(
      module,
      FunctionText("read_color", "Color of an image file, linear.")
          .takes("path", "str | os.PathLike[str]", "PNG, EXR, JPEG, TIFF, camera RAW, ...; 8 and 16 bit are sRGB codes")
          .returns("npt.NDArray[np.float32]", "H x W x 3, linear")
          .raises("IoError"),
      [](const py::object& given) {
        const std::string path = path_from(given);
        return array_of(result_of({}, [=](const RunControl&) { return read_color(path); }));
      });
  define(module,
         FunctionText("write_color",
                      "Writes color: .exr as half floats, others as 8-bit sRGB codes. Equal images give equal bytes.")
             .takes("path", "str | os.PathLike[str]", "Its extension says the format: .exr, .png, .jpg, .tif")
             .takes("linear", "npt.ArrayLike", "H x W x 3 of floats, linear")
             .raises("ParseError on another extension; InvalidInput; CannotComplete"),
         [](const py::object& given, const py::object& linear) {
           const std::string path = path_from(given);
           ImageF image = image_from(linear, "linear", 3);
           run_interruptibly({}, [path, image = std::move(image)](const RunControl&) { write_color(path, image); });
         });
  define(module,
         FunctionText("read_channels",
                      "Channels of an image file by name, as they are: codes / 255 (or / 65535), or floats.")
             .takes("path", "str | os.PathLike[str]", "")
             .takes("channels", "Sequence[str]", "As the file has them: R, G, B, A, Y, source.x")
             .returns("npt.NDArray[np.float32]", "H x W x channels, H x W of one")
             .raises("IoError naming a missing channel and those there are"),
         [](const py::object& given, const py::object& channels) {
           const std::string path = path_from(given);
           std::vector<std::string> names;
           for (const py::handle name : channels) names.push_back(py::cast<std::string>(name));
           return array_of(result_of({}, [=](const RunControl&) { return read_channels(path, names); }));
         });
  define(module,
         FunctionText("srgb_from_linear", "Linear color as 8-bit sRGB codes, clamped and rounded to nearest.")
             .takes("linear", "npt.ArrayLike", "H x W, or H x W x C, of floats")
             .returns("npt.NDArray[np.uint8]", "The same shape"),
         [](const py::object& linear) { return array_of(srgb8_from_linear(image_from(linear, "linear", 0))); });
  define(module,
         FunctionText("linear_from_srgb",
                      "Linear color of 8-bit sRGB codes; exact, so that srgb_from_linear() gives them back.")
             .takes("codes", "npt.ArrayLike", "H x W, or H x W x C, of uint8")
             .returns("npt.NDArray[np.float32]", "The same shape, in [0, 1]"),
         [](const py::object& codes) {
           const ImageU8 in = codes_from(codes, "codes");
           ImageF out(in.width(), in.height(), in.channels());
           for (std::size_t i = 0; i < in.values().size(); ++i)
             out.values()[i] = linear_from_srgb(static_cast<float>(in.values()[i]) / 255.0f);
           return array_of(std::move(out));
         });
}

}  // namespace patinate::python
