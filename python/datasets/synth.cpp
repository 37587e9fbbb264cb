#include <utility>

#include "datasets_synthetic/crackle_io.h"
#include "datasets_synthetic/drying_io.h"
#include "datasets_synthetic/dust_io.h"
#include "datasets_synthetic/edges.h"
#include "datasets_synthetic/mold_io.h"
#include "datasets_synthetic/object_io.h"
#include "datasets_synthetic/panel_io.h"
#include "datasets_synthetic/plate_io.h"
#include "python/bindings.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

template <class Options>
void define_synth(py::module_& module, const char* name, const char* brief,
                  JobPlan (*plan)(const Options&, const std::filesystem::path&)) {
  define(module,
         FunctionText(name, brief)
             .takes("output", "str | os.PathLike[str]", "Folder to make; a finished one of the same options stays")
             .keyword("force", "bool", "False", "Replace something different that lies there")
             .options<Options>()
             .runs()
             .raises("InvalidInput; CannotComplete if something else lies there"),
         [name, plan](const py::object& output, const py::kwargs& kwargs) {
           Keywords keywords(name, kwargs);
           Options options;
           keywords.read(options);
           const bool force = keywords.flag("force", false);
           const RunArguments run = keywords.run();
           keywords.finish();
           const std::string folder = path_from(output);
           run_interruptibly(
               run, [=](const RunControl& control) { run_job(plan(options, folder), {.force = force}, control); });
         });
}

}  // namespace

void bind_synth(py::module_& module) {
  define_synth<datasets::CrackleOptions>(
      module, "synth_crackle", "A capture of synthetic paint that cracks, with its truth.", datasets::plan_crackle);
  define_synth<datasets::DryingOptions>(
      module, "synth_drying", "A capture of a wet patch on stone that dries, with its truth.", datasets::plan_drying);
  define_synth<datasets::DustOptions>(module, "synth_dust", "A capture of an urn that gathers dust, with its truth.",
                                      datasets::plan_dust);
  define_synth<datasets::EdgesOptions>(module, "synth_edges", "A capture of a card of edge cases, with its truth.",
                                       datasets::plan_edges);
  define_synth<datasets::MoldOptions>(
      module, "synth_mold", "A capture of a synthetic mold, scanned under lamps step by step, with its truth.",
      datasets::plan_mold);
  define_synth<datasets::PanelOptions>(module, "synth_panel", "A capture of a coated panel that rusts, with its truth.",
                                       datasets::plan_panel);
  define_synth<datasets::PlateOptions>(
      module, "synth_plate", "A capture of a glossy plate under one lamp, with its truth.", datasets::plan_plate);
  define_synth<datasets::LedgeOptions>(module, "synth_ledge", "A wall with sills in the rain: a scene to simulate.",
                                       datasets::plan_ledge);
  define_synth<datasets::FenceOptions>(module, "synth_fence", "A fence in the weather: a scene to simulate.",
                                       datasets::plan_fence);
  define_synth<datasets::SculptureOptions>(module, "synth_sculpture", "A mesh to age.", datasets::plan_sculpture);
}

}  // namespace patinate::python
