#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/image/image_io.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/immutable.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

using SurfaceClass = py::class_<PySurface, std::shared_ptr<PySurface>>;
using ControlClass = py::class_<ControlMap, std::shared_ptr<ControlMap>>;

/// A value of three numbers at every texel, 0 outside.
template <class F>
py::array vectors_of(const TexelMap& map, F&& value) {
  ImageF out(map.width(), map.height(), 3);
  {
    const py::gil_scoped_release others_run;
    for (TexelId t = 0; t < map.num_texels(); ++t) {
      if (!map.is_covered(t)) continue;
      const Vec3 v = value(t);
      for (int c = 0; c < 3; ++c) out.data()[t * 3 + c] = static_cast<float>(v[c]);
    }
  }
  return array_of(std::move(out));
}

void bind_control(py::module_& module) {
  const char* const doc = "A parameter of the surface that aging follows, at every texel.";
  ControlClass type(module, "ControlMap", doc);
  begin_class_stub("ControlMap", doc);
  define_property(type, "values", "npt.NDArray[np.float32]",
                  "H x W in [0, 1]; 0 outside the charts; cannot be written.",
                  [](const py::object& self) { return read_only(py::cast<const ControlMap&>(self).values, self); });
  define_property(type, "low", "float", "What 0 stands for, in unit.", [](const ControlMap& map) { return map.low; });
  define_property(type, "high", "float", "What 1 stands for, in unit.", [](const ControlMap& map) { return map.high; });
  define_property(type, "unit", "str", "1/mm, cosine, ...; relative when only ratios mean something.",
                  [](const ControlMap& map) { return map.unit; });
  define_property(type, "notes", "list[str]", "What one should know about it.", [](const ControlMap& map) {
    py::list out;
    for (const std::string& note : map.notes) out.append(note);
    return out;
  });
  define_copies(type);
  define_equality<ControlMap>(type, [](const ControlMap& map) {
    ContentHash hash;
    return hash.add(std::as_bytes(map.values.values())).add(map.low).add(map.high).add(map.unit).hex();
  });
  define_method(type, FunctionText("__repr__", "In a line.").returns("str"), [](const ControlMap& map) {
    return "<patinate.ControlMap: " + std::to_string(map.values.width()) + " x " + std::to_string(map.values.height()) +
           ", " + short_number_text(map.low) + " to " + short_number_text(map.high) +
           (map.unit.empty() ? "" : " " + map.unit) + ">";
  });
  type.def(py::pickle(
      [](const ControlMap& map) {
        return py::make_tuple(array_of(ImageF(map.values)), map.low, map.high, map.unit, map.has_file, map.notes);
      },
      [](const py::tuple& state) {
        return std::make_shared<ControlMap>(ControlMap{.values = image_from(state[0], "values", 1),
                                                       .low = py::cast<double>(state[1]),
                                                       .high = py::cast<double>(state[2]),
                                                       .unit = py::cast<std::string>(state[3]),
                                                       .has_file = py::cast<bool>(state[4]),
                                                       .notes = py::cast<std::vector<std::string>>(state[5])});
      }));
  define_method(
      type,
      FunctionText("save", "Writes an EXR whose header says what 0 and 1 stand for; transfer() reads it as a control.")
          .takes("path", "str | os.PathLike[str]", "Ends in .exr")
          .raises("CannotComplete"),
      [](const ControlMap& map, const py::object& given) {
        const std::string path = path_from(given);
        run_interruptibly({}, [=](const RunControl&) {
          write_scaled_exr(path, map.values, {.low = map.low, .high = map.high, .unit = map.unit});
        });
      });
}

std::string surface_identity(const PySurface& surface) {
  const transfer::AgingSurface& s = surface.value;
  ContentHash hash;
  hash.add(mesh_identity(s.atlas->mesh)).add(std::int64_t{s.map->sheet().tile_width});
  for (const std::string& name : s.atlas->tile_names()) hash.add(name);
  return hash.add(s.texel_size_mm).add(s.mm_per_mesh_unit).hex();
}

py::tuple surface_state(const PySurface& surface) {
  const transfer::AgingSurface& s = surface.value;
  const AtlasMesh& atlas = *s.atlas;
  py::list tiles;
  for (const AtlasTile& t : atlas.tiles)
    tiles.append(py::make_tuple(t.name, t.origin.x(), t.origin.y(), t.shift.x(), t.shift.y(), t.scale));
  return py::make_tuple(PyMesh{std::shared_ptr<const Mesh>(s.atlas, &atlas.mesh)}, static_cast<int>(atlas.rule), tiles,
                        array_of(atlas.triangle_tile), atlas.is_unwrapped, atlas.notes, s.map->sheet().tile_width,
                        s.texel_size_mm, s.mm_per_mesh_unit, s.name, s.unit, surface.has_unit);
}

std::shared_ptr<PySurface> surface_of_state(const py::tuple& state) {
  auto atlas = std::make_shared<AtlasMesh>();
  atlas->mesh = *py::cast<const PyMesh&>(state[0]).value;
  atlas->rule = static_cast<UvLayoutRule>(py::cast<int>(state[1]));
  for (const py::handle tile : state[2]) {
    const auto t = py::cast<py::tuple>(tile);
    const auto number = [&](int i) { return py::cast<double>(t[i]); };
    atlas->tiles.push_back({.name = py::cast<std::string>(t[0]),
                            .origin = {number(1), number(2)},
                            .shift = {number(3), number(4)},
                            .scale = number(5)});
  }
  atlas->triangle_tile = py::cast<std::vector<int>>(state[3]);
  atlas->is_unwrapped = py::cast<bool>(state[4]);
  atlas->notes = py::cast<std::vector<std::string>>(state[5]);
  auto map = std::make_shared<const TexelMap>(make_texel_map(*atlas, py::cast<int>(state[6])));
  return std::make_shared<PySurface>(PySurface{.value = {.atlas = atlas,
                                                         .map = std::move(map),
                                                         .texel_size_mm = py::cast<double>(state[7]),
                                                         .mm_per_mesh_unit = py::cast<double>(state[8]),
                                                         .name = py::cast<std::string>(state[9]),
                                                         .unit = py::cast<std::optional<std::string>>(state[10])},
                                               .has_unit = py::cast<bool>(state[11])});
}

PySurface make_surface(const PyMesh& mesh, const py::kwargs& kwargs) {
  Keywords keywords("Surface", kwargs);
  SurfaceKeywords options;
  keywords.read(options);
  const RunArguments run = keywords.run();
  keywords.finish();
  return {.value = result_of(run,
                             [=](const RunControl& control) {
                               transfer::AgingSurface surface =
                                   transfer::make_aging_surface(*mesh.value, options.age, nullptr, control);
                               surface.name = mesh.name;
                               return surface;
                             }),
          .has_unit = options.age.mm_per_unit.has_value()};
}

}  // namespace

void bind_surface(py::module_& module) {
  bind_control(module);
  const char* const doc =
      "A mesh with texels: where each lies on the surface, and how large it is. Surface(mesh, *, resolution=1024, "
      "...).";
  SurfaceClass type(module, "Surface", doc);
  begin_class_stub("Surface", doc);
  const FunctionText init = FunctionText("__init__", "Repairs the mesh, scales it to mm and lays it out.")
                                .takes("mesh", "Mesh", "With UVs that make an atlas, or else it is unwrapped")
                                .options<SurfaceKeywords>()
                                .runs()
                                .raises("InvalidInput if the mesh cannot be textured or an option is out of range");
  type.def(py::init(&make_surface), FunctionText(init).of_class().docstring().c_str(), py::arg("mesh"));
  add_stub(FunctionText(init).of_class().stub());
  define_property(type, "mesh", "Mesh", "In mm, with UVs over the whole texture.", [](const PySurface& s) {
    return PyMesh{std::shared_ptr<const Mesh>(s.value.map, &s.value.map->mesh())};
  });
  define_copies(type);
  define_equality<PySurface>(type, &surface_identity);
  type.def(py::pickle(&surface_state, &surface_of_state));
  define_method(type, FunctionText("__repr__", "In a line.").returns("str"), [](const PySurface& s) {
    return "<patinate.Surface `" + s.value.name + "`: " + std::to_string(s.value.map->width()) + " x " +
           std::to_string(s.value.map->height()) + " texels>";
  });
  define_property(type, "width", "int", "Texels.", [](const PySurface& s) { return s.value.map->width(); });
  define_property(type, "height", "int", "Texels.", [](const PySurface& s) { return s.value.map->height(); });
  define_property(type, "texel_size_mm", "float", "Median over the surface of the length of a texel.",
                  [](const PySurface& s) { return s.value.map->median_texel_size_mm(); });
  define_property(type, "notes", "list[str]", "What was done to the UVs that one should know.", [](const PySurface& s) {
    py::list out;
    for (const std::string& note : s.value.atlas->notes) out.append(note);
    return out;
  });
  define_method(type,
                FunctionText("coverage", "Where texels show the surface.").returns("npt.NDArray[np.bool_]", "H x W"),
                [](const PySurface& s) { return mask_array(s.value.map->coverage()); });
  define_method(type,
                FunctionText("positions", "Surface points of the texels.")
                    .returns("npt.NDArray[np.float32]", "H x W x 3 in mm; 0 outside"),
                [](const PySurface& s) {
                  return vectors_of(*s.value.map, [&](TexelId t) { return s.value.map->position_mm(t); });
                });
  define_method(
      type,
      FunctionText("normals", "Shading normals of the texels.")
          .returns("npt.NDArray[np.float32]", "H x W x 3, unit; 0 outside"),
      [](const PySurface& s) { return vectors_of(*s.value.map, [&](TexelId t) { return s.value.map->normal(t); }); });
  define_method(type,
                FunctionText("control", "A control map of a kind, or of an expression of kinds and map files.")
                    .takes("expression", "str",
                           "accessibility, 'accessibility(scale=3)', ..., '0.7*facing + 0.3*!accessibility'; "
                           "control_kinds() lists them")
                    .options<ControlKindOptions>()
                    .runs()
                    .returns("ControlMap")
                    .raises("ParseError with a did-you-mean; IoError"),
                [](const PySurface& s, const std::string& expression, const py::kwargs& kwargs) {
                  Keywords keywords("control", kwargs);
                  ControlKindOptions options;
                  keywords.read(options);
                  const RunArguments run = keywords.run();
                  keywords.finish();
                  return result_of(run, [=](const RunControl& control) {
                    return make_control_expression(expression, *s.value.map, options, control);
                  });
                });
  define(module,
         FunctionText("control_kinds", "The kinds of control maps that expressions may name.")
             .returns("Report", "By name: where it is high"),
         [] {
           py::dict out;
           for (const ControlKind& kind : control_kinds()) out[kind.name.c_str()] = kind.brief;
           return out;
         });
}

}  // namespace patinate::python
