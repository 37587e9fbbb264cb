#include "patinate/capture/thickness.h"

#include <utility>

#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

void bind_thickness(py::module_& module) {
  define(
      module,
      FunctionText(
          "thickness",
          "Relative thickness of a layer from a photograph of the light that it lets through; cracks are filled.")
          .takes("photo", "npt.ArrayLike", "H x W of floats: linear transmitted light, finite inside the mask")
          .keyword("blank", "npt.ArrayLike | None", "None", "The same without the layer")
          .keyword("mask", "npt.ArrayLike | None", "None", "H x W of bool or integers, 0 outside")
          .options<capture::ThicknessOptions>()
          .keyword("deviation", "bool", "False", "Also the standard deviation by noise and grain: three times the work")
          .runs()
          .returns("Report",
                   "values: H x W, larger is thicker, only ratios mean something, 0 outside; low, high: robust range; "
                   "known: H x W, 0 or "
                   "255; window_px: the filter's; foretold_to: how well it foretells the layer, 0 where it was given; "
                   "deviation: H x W, when asked for; weak_share, two_modes, hole_share: of the layer, what to doubt")
          .raises("InvalidInput if sizes differ or nothing is left"),
      [](const py::object& photo, const py::kwargs& kwargs) {
        Keywords keywords("thickness", kwargs);
        capture::ThicknessOptions options;
        keywords.read(options);
        const py::object given_blank = keywords.object("blank");
        ImageU8 mask = optional_mask(keywords.object("mask"), "mask");
        options.with_deviation = keywords.flag("deviation", false);
        const RunArguments run = keywords.run();
        keywords.finish();
        ImageF light = image_from(photo, "photo", 1);
        ImageF blank = given_blank.is_none() ? ImageF() : image_from(given_blank, "blank", 1);
        capture::ThicknessMap map = result_of(run, [light = std::move(light), blank = std::move(blank),
                                                    mask = std::move(mask), options](const RunControl& control) {
          return capture::thickness_from_transmission(light, blank, mask, options, control);
        });
        py::dict out;
        out["values"] = array_of(std::move(map.values));
        out["low"] = map.low;
        out["high"] = map.high;
        out["known"] = array_of(std::move(map.known));
        if (options.with_deviation) out["deviation"] = array_of(std::move(map.deviation));
        out["window_px"] = map.window.sigma_px;
        out["foretold_to"] = map.window.foretold_to;
        out["weak_share"] = map.evidence.weak_share;
        out["two_modes"] = map.evidence.two_modes;
        out["hole_share"] = map.evidence.hole_share;
        return out;
      });
}

}  // namespace patinate::python
