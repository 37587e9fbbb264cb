#include <dlfcn.h>

#include <filesystem>

#include "libcommon/core/programs.h"
#include "python/bindings.h"
#include "python/support/errors.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace {

/// The interpreter is none of our programs: these lie where the module was installed or built.
void find_programs() {
  namespace fs = std::filesystem;
  Dl_info info{};
  static const char here = 0;
  if (::dladdr(&here, &info) == 0 || info.dli_fname == nullptr) return;
  const fs::path folder = fs::absolute(info.dli_fname).parent_path();
  for (const char* programs : {PATINATE_PROGRAMS_BUILT, PATINATE_PROGRAMS_INSTALLED}) {
    std::error_code error;
    if (fs::exists(folder / programs / "patinate-decode", error)) {
      set_programs_folder((folder / programs).lexically_normal());
      return;
    }
  }
}

}  // namespace

PYBIND11_MODULE(_native, module) {
  find_programs();
  pybind11::options texts;
  texts.disable_function_signatures();
  module.attr("__version__") = PATINATE_VERSION;
  bind_errors(module);
  bind_images(module);
  bind_history(module);
  bind_history_from_arrays(module);
  bind_appearance(module);
  bind_combine(module);
  bind_trim(module);
  bind_mesh(module);
  bind_surface(module);
  bind_transfer(module);
  bind_render(module);
  bind_export(module);
  bind_simulation(module);
  bind_simulate(module);
  bind_recompose(module);
  bind_compare(module);
  bind_grade(module);
  bind_evaluate(module);
  bind_explain(module);
  bind_factorize(module);
  bind_fit(module);
  bind_ingest(module);
  bind_register(module);
  bind_relief(module);
  bind_unlight(module);
  bind_thickness(module);
  bind_calibrate(module);
  bind_synth(module);
  bind_library(module);
  bind_study(module);
  module.def("_stubs", [] { return stubs(); });
  // After a call that Ctrl-C ended, its files are closed before the program ends.
  pybind11::module_::import("atexit").attr("register")(pybind11::cpp_function(&finish_left_work));
}

}  // namespace patinate::python
