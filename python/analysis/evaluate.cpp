#include <utility>

#include "analysis/evaluation/evaluation.h"
#include "app/evaluation/evaluated_maps.h"
#include "app/request/path_kind.h"
#include "patinate/core/error.h"
#include "python/analysis/py_analysis.h"
#include "python/bindings.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/transfer/py_transfer.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

using EvaluateKeywords = Seeded<analysis::EvaluationOptions>;

py::dict evaluation_dict(analysis::Evaluation made, std::vector<analysis::Figure> more) {
  more.insert(more.end(), made.figures.begin(), made.figures.end());
  py::dict out;
  out["figures"] = figures_of(more);
  out["pictures"] = pictures_of(std::move(made.pictures));
  out["hash"] = made.hash;
  return out;
}

}  // namespace

void bind_evaluate(py::module_& module) {
  define(module,
         FunctionText(
             "evaluate",
             "How good a transfer is: energy and audit, control error, statistics, repetition, seams, scale, lines.")
             .takes("transfer", "AgedMesh | str | os.PathLike[str]", "Or the path of a transfer folder")
             .options<EvaluateKeywords>({.seed = kDefaultSeed})
             .runs()
             .returns("Report",
                      "figures: by name value, unit, split (what two draws from the source itself give), undefined "
                      "(why there is no "
                      "value); pictures: name, caption, image; hash: of the coordinates")
             .raises("InvalidInput, IoError"),
         [](const py::object& given, const py::kwargs& kwargs) {
           Keywords keywords("evaluate", kwargs);
           EvaluateKeywords options{.seed = kDefaultSeed};
           keywords.read(options);
           const RunArguments run = keywords.run();
           keywords.finish();
           const auto seed = static_cast<std::uint64_t>(options.seed);
           const PyAged aged = py::isinstance<PyAged>(given) ? py::cast<const PyAged&>(given)
                                                             : PyAged{.value = nullptr, .path = path_from(given)};
           auto [made, more] = result_of(run, [=](const RunControl& control) {
             if (!aged.value) app::require_transfer(aged.path);
             const analysis::MapToEvaluate opened =
                 aged.path.empty()
                     ? app::aged_map("transfer", *aged.value, options.options, seed, control.part(0.0, 0.5))
                     : app::transfer_item(aged.path, options.options, seed, {}).open(control.part(0.0, 0.5));
             return std::pair(
                 analysis::evaluate(opened.source, opened.map, options.options, seed, nullptr, control.part(0.5, 1.0)),
                 opened.more);
           });
           return evaluation_dict(std::move(made), std::move(more));
         });
}

}  // namespace patinate::python
