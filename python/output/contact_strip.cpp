#include "libcommon/output/contact_strip.h"

#include <utility>

#include "patinate/core/error.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

void bind_contact_strip(py::module_& module) {
  define(module,
         FunctionText("contact_strip", "Several pictures side by side with a label under each, as strips of render().")
             .takes("pictures", "Sequence[npt.ArrayLike]", "Of one size, H x W x 3 or H x W, linear")
             .keyword("labels", "Sequence[str] | None", "None", "As many as pictures; printable ASCII")
             .keyword("columns", "int", "0", "Pictures in a row; 0: all")
             .returns("npt.NDArray[np.float32]", "H x W x 3, linear")
             .raises("InvalidInput if there is no picture, or sizes or numbers differ"),
         [](const py::object& pictures, const py::kwargs& kwargs) {
           Keywords keywords("contact_strip", kwargs);
           const py::object given = keywords.object("labels");
           const std::int64_t columns = keywords.integer("columns", 0);
           keywords.finish();
           constexpr std::int64_t kMost = 100000;
           if (columns < 0 || columns > kMost)
             throw InvalidInput("columns: " + std::to_string(columns) + " is out of range; use [0, 100000]");
           std::vector<ImageF> images;
           for (const py::handle picture : pictures)
             images.push_back(image_from(py::reinterpret_borrow<py::object>(picture), "pictures", 0));
           std::vector<std::string> labels;
           if (!given.is_none()) {
             for (const py::handle label : given) labels.push_back(py::cast<std::string>(label));
           }
           return array_of(
               result_of({}, [columns, images = std::move(images), labels = std::move(labels)](const RunControl&) {
                 return patinate::contact_strip(images, labels, {.columns = static_cast<int>(columns)});
               }));
         });
}

}  // namespace patinate::python
