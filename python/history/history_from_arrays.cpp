#include <utility>

#include "patinate/core/error.h"
#include "patinate/history/memory_history.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

constexpr const char* kFunction = "history_from_arrays";

/// Values alone, or (values, low, high, unit).
MemoryControl control_from(const std::string& name, const py::object& given) {
  MemoryControl control{.facts = {.name = name}, .values = {}};
  py::object values = given;
  if (py::isinstance<py::tuple>(given)) {
    const auto parts = py::cast<py::tuple>(given);
    if (parts.size() != 4)
      wrong_type(kFunction, "controls[" + name + "]", given, "values, or (values, low, high, unit)");
    values = parts[0];
    control.facts.low = py::cast<double>(parts[1]);
    control.facts.high = py::cast<double>(parts[2]);
    control.facts.unit = py::cast<std::string>(parts[3]);
  }
  control.values = image_from(values, "controls[" + name + "]", 1);
  return control;
}

py::dict dict_from(Keywords& keywords, const char* name) {
  const py::object given = keywords.object(name);
  if (given.is_none()) return {};
  if (!py::isinstance<py::dict>(given)) wrong_type(kFunction, name, given, "a dict of arrays by name");
  return given;
}

/// One entry a frame of a list that may be missing.
py::object of_frame(const py::object& list, std::size_t frame, std::size_t num_frames, const char* name) {
  if (list.is_none()) return py::none();
  if (py::len(list) != num_frames)
    throw InvalidInput(std::string(name) + ": has " + std::to_string(py::len(list)) +
                       " entries; expected one for each of " + std::to_string(num_frames) + " frames");
  return list[py::int_(frame)];
}

MemoryHistoryImages images_from(const py::object& colors, const py::object& times, Keywords& keywords) {
  MemoryHistoryImages images{.name = keywords.text("name", "history"), .frames = {}};
  images.origin = keywords.text("origin", images.origin);
  images.texel_size_mm = keywords.number("texel_size_mm");
  images.time_unit = parse_time_unit(keywords.text("time_unit", time_unit_text(images.time_unit)));
  const py::object masks = keywords.object("frame_masks"), extras = keywords.object("frame_extras");
  const std::vector<double> at = numbers_from(times, "times");
  if (py::len(colors) != at.size())
    throw InvalidInput("colors: has " + std::to_string(py::len(colors)) + " frames; times has " +
                       std::to_string(at.size()));
  for (std::size_t i = 0; i < at.size(); ++i) {
    const std::string what = "colors[" + std::to_string(i) + "]";
    MemoryFrame frame{.time = at[i], .color = image_from(colors[py::int_(i)], what, 3)};
    frame.mask = optional_mask(of_frame(masks, i, at.size(), "frame_masks"), "mask of " + what);
    const py::object extra = of_frame(extras, i, at.size(), "frame_extras");
    if (!extra.is_none()) {
      for (const auto& [name, values] : py::cast<py::dict>(extra)) {
        const auto key = py::cast<std::string>(name);
        frame.extras.push_back({key, image_from(py::reinterpret_borrow<py::object>(values), key + " of " + what, 0)});
      }
    }
    images.frames.push_back(std::move(frame));
  }
  for (const auto& [name, given] : dict_from(keywords, "controls"))
    images.controls.push_back(control_from(py::cast<std::string>(name), py::reinterpret_borrow<py::object>(given)));
  for (const auto& [name, given] : dict_from(keywords, "maps")) {
    const auto key = py::cast<std::string>(name);
    images.maps.push_back({key, image_from(py::reinterpret_borrow<py::object>(given), "maps[" + key + "]", 0)});
  }
  images.mask = optional_mask(keywords.object("mask"), "mask");
  return images;
}

}  // namespace

void bind_history_from_arrays(py::module_& module) {
  define(
      module,
      FunctionText(kFunction,
                   "A history of images in memory. They are copied once; color stays as precise as it is given.")
          .takes("colors", "npt.ArrayLike | Sequence[npt.ArrayLike]",
                 "T x H x W x 3, or T images H x W x 3: floats, linear, finite")
          .takes("times", "npt.ArrayLike", "T, in time_unit, strictly increasing")
          .keyword("name", "str", "'history'", "What the material is called")
          .keyword("origin", "Literal['captured', 'simulated', 'synthetic']", "'captured'", "Where it comes from")
          .keyword("time_unit", "Literal['s', 'min', 'h', 'd', 'a']", "'s'", "Of times; a: years of 365.25 d")
          .keyword("texel_size_mm", "float | None", "None", "Surface length of a pixel, where it is known (mm)")
          .keyword("controls", "Mapping[str, npt.ArrayLike | tuple[npt.ArrayLike, float, float, str]]", "None",
                   "By name: H x W in [0, 1], or (values, what 0 stands for, what 1 stands for, unit)")
          .keyword("mask", "npt.ArrayLike | None", "None", "H x W of bool or integers, 0 outside; None: all is inside")
          .keyword("maps", "Mapping[str, npt.ArrayLike]", "None",
                   "Constant in time: position (H x W x 3, mm), normal (H x W x 3), height, texel_size (H x W, mm), "
                   "specular, "
                   "metalness, tint as frame_extras")
          .keyword("frame_masks", "Sequence[npt.ArrayLike | None]", "None",
                   "A mask for each frame, or None: where its color is the surface's")
          .keyword("frame_extras", "Sequence[Mapping[str, npt.ArrayLike] | None]", "None",
                   "For each frame stddev (H x W x 3), specular (H x W x 2: strength, roughness), normal (H x W x 3), "
                   "height (H x W, mm), metalness (H x W), tint (H x W x 3)")
          .returns("History")
          .raises("InvalidInput naming what is wrong with which image"),
      [](const py::object& colors, const py::object& times, const py::kwargs& kwargs) {
        Keywords keywords(kFunction, kwargs);
        MemoryHistoryImages images = images_from(colors, times, keywords);
        keywords.finish();
        const py::gil_scoped_release others_run;
        return PyHistory{std::make_shared<const MemoryHistory>(std::move(images))};
      });
}

}  // namespace patinate::python
