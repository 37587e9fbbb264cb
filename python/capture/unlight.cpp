#include "patinate/capture/unlight.h"

#include <utility>

#include "patinate/core/error.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

/// {"position": [x, y, z] or "direction": [...], "intensity": number or [r, g, b]}, as a project has them, in mm.
Light light_from(const py::handle& given, const std::string& what) {
  if (!py::isinstance<py::dict>(given)) wrong_type("unlight", what, given, "a dict with position or direction");
  const auto dict = py::reinterpret_borrow<py::dict>(given);
  Light light;
  for (const auto& [name, value] : dict) {
    const auto key = py::cast<std::string>(name);
    if (key == "position") {
      light.position = vector_from(value, what + "[position]");
    } else if (key == "direction") {
      light.kind = Light::Kind::Directional;
      light.direction = vector_from(value, what + "[direction]");
      if (!(light.direction.norm() > 0.0)) throw InvalidInput(what + "[direction]: has no length");
      light.direction.normalize();
    } else if (key == "intensity") {
      light.intensity = py::isinstance<py::float_>(value) || py::isinstance<py::int_>(value)
                            ? Vec3(Vec3::Constant(py::cast<double>(value)))
                            : vector_from(value, what + "[intensity]");
    } else {
      throw InvalidInput(what + ": has no `" + key + "`; expected position or direction, and intensity");
    }
  }
  if (dict.contains("position") == dict.contains("direction"))
    throw InvalidInput(what + ": expected either position or direction");
  return light;
}

capture::UnlightInput input_from(const py::object& photos, const py::object& lights, Keywords& keywords) {
  capture::UnlightInput input;
  std::size_t i = 0;
  for (const py::handle photo : photos) {
    const auto array = py::reinterpret_borrow<py::object>(photo);
    const std::string what = "photos[" + std::to_string(i++) + "]";
    input.photos.push_back(image_from(array, what, 0));
  }
  i = 0;
  for (const py::handle light : lights)
    input.lights.push_back(light_from(light, "lights[" + std::to_string(i++) + "]"));
  const py::object valid = keywords.object("valid"), position = keywords.object("position_mm"),
                   normal = keywords.object("normal");
  if (!valid.is_none()) {
    i = 0;
    for (const py::handle v : valid)
      input.valid.push_back(mask_from(py::reinterpret_borrow<py::object>(v), "valid[" + std::to_string(i++) + "]"));
  }
  if (!position.is_none()) input.position_mm = image_from(position, "position_mm", 3);
  if (!normal.is_none()) input.normal = image_from(normal, "normal", 3);
  input.mask = optional_mask(keywords.object("mask"), "mask");
  const py::object camera = keywords.object("camera_center"), view = keywords.object("view_direction");
  if (!camera.is_none()) input.camera_center = vector_from(camera, "camera_center");
  if (!view.is_none()) input.view_direction = vector_from(view, "view_direction").normalized();
  return input;
}

py::dict unlit_dict(capture::UnlightResult made) {
  py::dict out;
  out["albedo"] = array_of(std::move(made.albedo));
  out["stddev"] = array_of(std::move(made.stddev));
  out["normal"] = array_of(std::move(made.normal));
  if (!made.specular.empty()) out["specular"] = array_of(std::move(made.specular));
  if (!made.reflectance.empty()) {
    out["reflectance"] = array_of(std::move(made.reflectance));
    out["metalness"] = array_of(std::move(made.metalness));
  }
  out["mask"] = array_of(std::move(made.mask));
  out["samples"] = array_of(std::move(made.samples));
  py::list strengths;
  for (const capture::LightReport& light : made.lights)
    strengths.append(py::make_tuple(light.strength[0], light.strength[1], light.strength[2]));
  out["strengths"] = strengths;
  out["ambient"] = py::make_tuple(made.ambient[0], made.ambient[1], made.ambient[2]);
  out["residual"] = made.residual;
  out["is_converged"] = made.is_converged;
  py::list notes;
  for (const std::string& note : made.notes) notes.append(note);
  out["notes"] = notes;
  return out;
}

}  // namespace

void bind_unlight(py::module_& module) {
  define(module,
         FunctionText("unlight", "Albedo, normals and highlights from photographs of one view under known lamps.")
             .takes("photos", "Sequence[npt.ArrayLike]",
                    "L images H x W x 3 or H x W of floats, linear, the ambient light subtracted")
             .takes("lights", "Sequence[Mapping[str, Any]]",
                    "L dicts: 'position' [x, y, z] in mm or 'direction' [x, y, z] to the light; 'intensity' (a number "
                    "or [r, g, b]; default 1)")
             .keyword("position_mm", "npt.ArrayLike | None", "None", "H x W x 3; needed by near lamps")
             .keyword("normal", "npt.ArrayLike | None", "None",
                      "H x W x 3 from a scan, 0 where it has none; None: from the photographs alone")
             .keyword("mask", "npt.ArrayLike | None", "None", "H x W, 0 = no surface")
             .keyword("valid", "Sequence[npt.ArrayLike] | None", "None", "L images H x W, 0 = saturated or out of view")
             .keyword("blockers", "Mesh | None", "None", "Casts shadows, in mm")
             .keyword("camera_center", "Sequence[float] | None", "None", "mm; None: far away along view_direction")
             .keyword("view_direction", "Sequence[float] | None", "None",
                      "From the surface to the camera; None: (0, 0, 1)")
             .options<capture::UnlightOptions>()
             .runs()
             .returns("Report",
                      "albedo and stddev: as the photos, 0 where not determined; normal: H x W x 3, unit; specular: H "
                      "x W x 2, strength and "
                      "roughness; with specular 'material' reflectance (H x W x 3, F0) and metalness (H x W); mask: "
                      "255 = determined; samples: H x W x L, what became of each (1 = it counted); "
                      "strengths, ambient, residual, "
                      "is_converged, notes")
             .raises("InvalidInput if sizes differ, near lamps have no positions, or no lamp reaches the surface"),
         [](const py::object& photos, const py::object& lights, const py::kwargs& kwargs) {
           Keywords keywords("unlight", kwargs);
           capture::UnlightOptions options;
           keywords.read(options);
           capture::UnlightInput input = input_from(photos, lights, keywords);
           const py::object blockers = keywords.object("blockers");
           const RunArguments run = keywords.run();
           keywords.finish();
           std::shared_ptr<const Mesh> mesh;
           if (!blockers.is_none()) mesh = py::cast<const PyMesh&>(blockers).value;
           return unlit_dict(result_of(run, [=, input = std::move(input)](const RunControl& control) mutable {
             input.blockers = mesh.get();
             return capture::unlight(input, options, control);
           }));
         });
}

}  // namespace patinate::python
