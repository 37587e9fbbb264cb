#include <utility>

#include "analysis/explanation/explanation.h"
#include "analysis/explanation/surface_places.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "python/analysis/py_analysis.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

using ExplainKeywords = Seeded<analysis::ExplanationOptions>;

/// A map, or the expression that makes it.
struct Candidate {
  std::string name;
  ImageF values;  ///< Empty: of the expression `name`.
};

std::vector<Candidate> candidates_from(const py::object& given) {
  std::vector<Candidate> out;
  if (py::isinstance<py::dict>(given)) {
    for (const auto& [key, value] : py::cast<py::dict>(given)) {
      const auto name = py::cast<std::string>(key);
      out.push_back({name, py::isinstance<ControlMap>(value)
                               ? py::cast<const ControlMap&>(value).values
                               : image_from(py::reinterpret_borrow<py::object>(value), "candidates[" + name + "]", 1)});
    }
  } else if (py::isinstance<py::sequence>(given) && !py::isinstance<py::str>(given)) {
    for (const py::handle text : given) out.push_back({py::cast<std::string>(text), {}});
  } else {
    wrong_type("explain", "candidates", given, "a list of expressions, or a dict of maps");
  }
  if (out.empty()) throw InvalidInput("candidates: there are none");
  return out;
}

py::dict explanation_dict(const analysis::ExplanationFigures& f) {
  py::dict out;
  out["correlation"] = f.correlation;
  out["low"] = f.low ? py::object(py::float_(*f.low)) : py::none();
  out["high"] = f.high ? py::object(py::float_(*f.high)) : py::none();
  out["p"] = f.p;
  out["corrected_p"] = f.corrected_p;
  out["explains"] = f.explains;
  return out;
}

}  // namespace

void bind_explain(py::module_& module) {
  define(
      module,
      FunctionText("explain",
                   "Which control says where a surface aged: rank correlations with intervals, and the best mix.")
          .takes("surface", "Surface", "What aged")
          .takes("reference", "npt.ArrayLike", "H x W over it: how much it aged; any unit, only the order counts")
          .takes("candidates", "Sequence[str] | Mapping[str, ControlMap | npt.ArrayLike]",
                 "Expressions as Surface.control() takes them, or maps H x W in [0, 1] by name")
          .keyword("mask", "npt.ArrayLike | None", "None", "H x W of bool or integers, 0 = not looked at")
          .options<ExplainKeywords>({.seed = kDefaultSeed})
          .runs()
          .returns("Report",
                   "candidates: by name, the strongest first, correlation, low and high (95 %), p, corrected_p, "
                   "explains; mix: expression for transfer(), its figures, left_out_correlation; num_blocks, block_mm")
          .raises("InvalidInput on too few places or shuffles, or a reference that is the same everywhere"),
      [](const PySurface& surface, const py::object& reference, const py::object& candidates,
         const py::kwargs& kwargs) {
        Keywords keywords("explain", kwargs);
        ExplainKeywords options{.seed = kDefaultSeed};
        keywords.read(options);
        ImageU8 mask = optional_mask(keywords.object("mask"), "mask");
        const RunArguments run = keywords.run();
        keywords.finish();
        const std::shared_ptr<const TexelMap> map = surface.value.map;
        ImageF aged = image_from(reference, "reference", 1);
        std::vector<Candidate> asked = candidates_from(candidates);
        const auto check = [&](const auto& image, const std::string& what) {
          if (image.width() == map->width() && image.height() == map->height()) return;
          throw InvalidInput(what + ": is " + std::to_string(image.height()) + " x " + std::to_string(image.width()) +
                             "; the surface has " + std::to_string(map->height()) + " x " +
                             std::to_string(map->width()) + " texels");
        };
        check(aged, "reference");
        if (!mask.empty()) check(mask, "mask");
        for (const Candidate& c : asked) {
          if (!c.values.empty()) check(c.values, "candidates[" + c.name + "]");
        }
        const analysis::Explanation found =
            result_of(run, [=, aged = std::move(aged), mask = std::move(mask),
                            asked = std::move(asked)](const RunControl& control) mutable {
              const analysis::SurfacePlaces places = analysis::surface_places(*map, mask, options.options.num_samples);
              analysis::ExplanationInput input{.positions_mm = places.positions_mm,
                                               .area_mm2 = places.area_mm2,
                                               .reference = places.values_of(aged),
                                               .candidates = {}};
              for (Candidate& c : asked) {
                if (c.values.empty())
                  c.values = make_control_expression(c.name, *map, {}, control.part(0.0, 0.0)).values;
                input.candidates.push_back({c.name, places.values_of(c.values)});
              }
              return analysis::explain(input, options.options, static_cast<std::uint64_t>(options.seed),
                                       control.part(0.1, 1.0));
            });
        py::dict figures, mix, out;
        for (const analysis::ExplainedCandidate& c : found.candidates) {
          if (!c.is_even) figures[c.name.c_str()] = explanation_dict(c.figures);
        }
        mix = explanation_dict(found.mix.figures);
        mix["expression"] = found.mix.expression;
        mix["left_out_correlation"] = found.mix.left_out_correlation;
        out["candidates"] = figures;
        out["mix"] = mix;
        out["num_blocks"] = found.num_blocks;
        out["block_mm"] = found.block_mm;
        return out;
      });
}

}  // namespace patinate::python
