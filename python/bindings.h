/// \file
/// What module.cpp puts together: each adds its functions and classes, those that name others behind these.
#pragma once

#include <pybind11/pybind11.h>

namespace patinate::python {

void bind_images(pybind11::module_& module);
void bind_history(pybind11::module_& module);
void bind_history_from_arrays(pybind11::module_& module);
void bind_appearance(pybind11::module_& module);
void bind_combine(pybind11::module_& module);
void bind_trim(pybind11::module_& module);
void bind_mesh(pybind11::module_& module);
void bind_surface(pybind11::module_& module);
void bind_transfer(pybind11::module_& module);
void bind_render(pybind11::module_& module);
void bind_export(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);
void bind_simulate(pybind11::module_& module);
void bind_recompose(pybind11::module_& module);
void bind_compare(pybind11::module_& module);
void bind_grade(pybind11::module_& module);
void bind_evaluate(pybind11::module_& module);
void bind_explain(pybind11::module_& module);
void bind_factorize(pybind11::module_& module);
void bind_fit(pybind11::module_& module);
void bind_ingest(pybind11::module_& module);
void bind_register(pybind11::module_& module);
void bind_relief(pybind11::module_& module);
void bind_unlight(pybind11::module_& module);
void bind_thickness(pybind11::module_& module);
void bind_calibrate(pybind11::module_& module);
void bind_study(pybind11::module_& module);
void bind_synth(pybind11::module_& module);
void bind_library(pybind11::module_& module);

}  // namespace patinate::python
