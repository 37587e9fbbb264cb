#include <cmath>
#include <span>
#include <utility>

#include "libcommon/core/hash.h"
#include "libcommon/geometry/mesh_key.h"
#include "patinate/atlas/unwrap.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/mesh_io.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/immutable.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

using MeshClass = py::class_<PyMesh, std::shared_ptr<PyMesh>>;

PyMesh kept(Mesh mesh) { return {std::make_shared<const Mesh>(std::move(mesh))}; }

/// A view of the mesh's own numbers, N x columns.
template <class T, class V>
py::array view(const std::vector<V>& rows, py::ssize_t columns, const py::object& owner) {
  static_assert(sizeof(V) % sizeof(T) == 0);
  return read_only(reinterpret_cast<const T*>(rows.data()), {static_cast<py::ssize_t>(rows.size()), columns}, owner);
}

template <class V>
std::vector<V> vectors_from(const py::object& given, const std::string& what, int columns) {
  const auto rows = rows_from(given, what, columns);
  std::vector<V> out(static_cast<std::size_t>(rows.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (int k = 0; k < columns; ++k) {
      out[i][k] = rows.at(static_cast<py::ssize_t>(i), k);
      if (!std::isfinite(out[i][k])) throw InvalidInput(what + ": row " + std::to_string(i) + " is not finite");
    }
  }
  return out;
}

/// @param num_entries  Of what the indices are of. @param least  -1 where a corner may have none.
std::vector<Triangle> triangles_from(const py::object& given, const std::string& what, std::size_t num_entries,
                                     int least) {
  const auto rows = index_rows_from(given, what, 3);
  std::vector<Triangle> out(static_cast<std::size_t>(rows.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int index = rows.at(static_cast<py::ssize_t>(i), k);
      if (index < least || index >= static_cast<int>(num_entries))
        throw InvalidInput(what + ": row " + std::to_string(i) + " has the index " + std::to_string(index) +
                           "; expected " + std::to_string(least) + " to " +
                           std::to_string(static_cast<int>(num_entries) - 1));
      out[i][k] = index;
    }
  }
  return out;
}

/// Indices of uvs or normals: those of the corners unless they are given.
std::vector<Triangle> corner_indices(const py::object& given, const std::string& what, std::size_t num_entries,
                                     int least, const Mesh& mesh) {
  if (num_entries == 0) return {};
  if (given.is_none()) {
    if (num_entries != mesh.positions.size())
      throw InvalidInput(what + ": is needed, since there are " + std::to_string(num_entries) + " entries for " +
                         std::to_string(mesh.positions.size()) + " positions");
    return mesh.triangles;
  }
  std::vector<Triangle> out = triangles_from(given, what, num_entries, least);
  if (out.size() != mesh.triangles.size())
    throw InvalidInput(what + ": has " + std::to_string(out.size()) + " rows; triangles has " +
                       std::to_string(mesh.triangles.size()));
  return out;
}

Mesh mesh_from(const py::object& positions, const py::object& triangles, Keywords& keywords) {
  Mesh mesh;
  mesh.positions = vectors_from<Vec3>(positions, "positions", 3);
  mesh.triangles = triangles_from(triangles, "triangles", mesh.positions.size(), 0);
  if (mesh.triangles.empty()) throw InvalidInput("triangles: there are none");
  const py::object uvs = keywords.object("uvs"), normals = keywords.object("normals");
  const py::object uv_triangles = keywords.object("uv_triangles"),
                   normal_triangles = keywords.object("normal_triangles");
  if (!uvs.is_none()) mesh.uvs = vectors_from<Vec2>(uvs, "uvs", 2);
  if (!normals.is_none()) mesh.normals = vectors_from<Vec3>(normals, "normals", 3);
  mesh.uv_triangles = corner_indices(uv_triangles, "uv_triangles", mesh.uvs.size(), -1, mesh);
  mesh.normal_triangles = corner_indices(normal_triangles, "normal_triangles", mesh.normals.size(), 0, mesh);
  for (Vec3& n : mesh.normals) {
    if (!(n.norm() > 0.0)) throw InvalidInput("normals: one has no length");
    n.normalize();
  }
  mesh.surfaces.push_back({.node = "", .material = ""});
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  return mesh;
}

void define_arrays(MeshClass& type) {
  define_property(
      type, "positions", "npt.NDArray[np.float64]", "N x 3, in the file's unit; cannot be written.",
      [](const py::object& self) { return view<double>(py::cast<const PyMesh&>(self).value->positions, 3, self); });
  define_property(
      type, "triangles", "npt.NDArray[np.int32]", "M x 3 into positions, counter-clockwise from outside.",
      [](const py::object& self) { return view<int>(py::cast<const PyMesh&>(self).value->triangles, 3, self); });
  define_property(
      type, "uvs", "npt.NDArray[np.float64]", "K x 2, v up; empty when it has none.",
      [](const py::object& self) { return view<double>(py::cast<const PyMesh&>(self).value->uvs, 2, self); });
  define_property(
      type, "uv_triangles", "npt.NDArray[np.int32]", "M x 3 into uvs, -1: none; or empty.",
      [](const py::object& self) { return view<int>(py::cast<const PyMesh&>(self).value->uv_triangles, 3, self); });
  define_property(
      type, "normals", "npt.NDArray[np.float64]", "L x 3, unit; empty when it has none.",
      [](const py::object& self) { return view<double>(py::cast<const PyMesh&>(self).value->normals, 3, self); });
  define_property(
      type, "normal_triangles", "npt.NDArray[np.int32]", "M x 3 into normals; or empty.",
      [](const py::object& self) { return view<int>(py::cast<const PyMesh&>(self).value->normal_triangles, 3, self); });
  define_property(type, "surfaces", "list[tuple[str, str]]", "(node, material) of each surface of the file.",
                  [](const PyMesh& mesh) {
                    py::list out;
                    for (const Mesh::Surface& s : mesh.value->surfaces) out.append(py::make_tuple(s.node, s.material));
                    return out;
                  });
}

void define_work(MeshClass& type) {
  define_method(type,
                FunctionText("select", "Only the triangles of a node, of a material, or of both.")
                    .keyword("node", "str", "''", "'' = any")
                    .keyword("material", "str", "''", "'' = any")
                    .returns("Mesh")
                    .raises("InvalidInput listing the names there are if nothing remains"),
                [](const PyMesh& mesh, const py::kwargs& kwargs) {
                  Keywords keywords("select", kwargs);
                  const std::string node = keywords.text("node", ""), material = keywords.text("material", "");
                  keywords.finish();
                  return kept(select_surfaces(*mesh.value, node, material));
                });
  define_method(type,
                FunctionText("unwrap", "New UVs: every texel shows one point of the surface.")
                    .options<UnwrapOptions>()
                    .runs()
                    .returns("Mesh", "The same with uvs and uv_triangles, all in [0, 1]")
                    .raises("InvalidInput if it has no area, or more pieces than an atlas has room for"),
                [](const PyMesh& mesh, const py::kwargs& kwargs) {
                  Keywords keywords("unwrap", kwargs);
                  UnwrapOptions options;
                  keywords.read(options);
                  const RunArguments run = keywords.run();
                  keywords.finish();
                  return kept(result_of(run, [=](const RunControl& control) {
                                return unwrap(*mesh.value, options, control);
                              }).mesh);
                });
  define_method(type,
                FunctionText("save", "Writes an OBJ whose numbers read back exactly.")
                    .takes("path", "str | os.PathLike[str]", "Ends in .obj")
                    .raises("CannotComplete"),
                [](const PyMesh& mesh, const py::object& given) {
                  const std::string path = path_from(given);
                  if (!path.ends_with(".obj")) throw ParseError(path + ": meshes are saved as .obj");
                  run_interruptibly({}, [=](const RunControl&) { write_obj(path, *mesh.value); });
                });
  define_copies(type);
  define_equality<PyMesh>(type, [](const PyMesh& mesh) { return mesh_identity(*mesh.value); });
  type.def(py::pickle(
      [](const py::object& self) {
        const PyMesh& mesh = py::cast<const PyMesh&>(self);
        py::list names;
        for (const Mesh::Surface& s : mesh.value->surfaces) names.append(py::make_tuple(s.node, s.material));
        return py::make_tuple(self.attr("positions"), self.attr("triangles"), self.attr("uvs"),
                              self.attr("uv_triangles"), self.attr("normals"), self.attr("normal_triangles"), names,
                              array_of(mesh.value->triangle_surface), mesh.name);
      },
      [](const py::tuple& state) {
        Mesh mesh;
        mesh.positions = vectors_from<Vec3>(state[0], "positions", 3);
        mesh.triangles = triangles_from(state[1], "triangles", mesh.positions.size(), 0);
        mesh.uvs = vectors_from<Vec2>(state[2], "uvs", 2);
        mesh.uv_triangles = triangles_from(state[3], "uv_triangles", mesh.uvs.size(), -1);
        mesh.normals = vectors_from<Vec3>(state[4], "normals", 3);
        mesh.normal_triangles = triangles_from(state[5], "normal_triangles", mesh.normals.size(), 0);
        for (const py::handle name : state[6]) {
          const auto pair = py::cast<py::tuple>(name);
          mesh.surfaces.push_back({py::cast<std::string>(pair[0]), py::cast<std::string>(pair[1])});
        }
        for (const py::handle surface : state[7]) mesh.triangle_surface.push_back(py::cast<int>(surface));
        return PyMesh{std::make_shared<const Mesh>(std::move(mesh)), py::cast<std::string>(state[8])};
      }));
  define_method(type, FunctionText("__repr__", "In a line.").returns("str"), [](const PyMesh& mesh) {
    return "<patinate.Mesh: " + std::to_string(mesh.value->num_triangles()) + " triangles" +
           (mesh.value->has_uvs() ? ", with UVs>" : ">");
  });
}

}  // namespace

std::string mesh_identity(const Mesh& mesh) {
  ContentHash hash;
  hash.add(mesh_content_key(mesh)).add(std::as_bytes(std::span(mesh.triangle_surface)));
  for (const Mesh::Surface& s : mesh.surfaces) hash.add(s.node).add(s.material);
  return hash.hex();
}

MeshesByPath meshes_from(const char* function, const py::object& given, const std::filesystem::path& folder) {
  MeshesByPath out;
  if (given.is_none()) return out;
  if (!py::isinstance<py::dict>(given)) wrong_type(function, "meshes", given, "a dict of meshes by name");
  for (const auto& [name, mesh] : py::cast<py::dict>(given)) {
    if (!py::isinstance<py::str>(name) || !py::isinstance<PyMesh>(mesh))
      wrong_type(function, "meshes", mesh, "a Mesh by name");
    out[folder / py::cast<std::string>(name)] = py::cast<const PyMesh&>(mesh).value;
  }
  return out;
}

void bind_mesh(py::module_& module) {
  const char* const doc =
      "A triangle mesh with plain arrays; positions, UVs and normals are indexed separately. Immutable.";
  MeshClass type(module, "Mesh", doc);
  begin_class_stub("Mesh", doc);
  define_arrays(type);
  define_work(type);
  define(module,
         FunctionText("read_mesh", "Reads OBJ, PLY, STL, glTF or GLB.")
             .takes("path", "str | os.PathLike[str]", "Polygons are triangulated, node transforms applied")
             .returns("Mesh", "In the file's unit (glTF: m)")
             .raises("IoError"),
         [](const py::object& given) {
           const std::string path = path_from(given);
           PyMesh mesh = kept(result_of({}, [=](const RunControl&) { return read_mesh(path); }));
           mesh.name = std::filesystem::path(path).filename().string();
           return mesh;
         });
  define(module,
         FunctionText("mesh_from_arrays", "A mesh of arrays, which are copied once.")
             .takes("positions", "npt.ArrayLike", "N x 3, finite")
             .takes("triangles", "npt.ArrayLike", "M x 3 of integers, counter-clockwise seen from outside")
             .keyword("uvs", "npt.ArrayLike | None", "None", "K x 2, v up")
             .keyword("uv_triangles", "npt.ArrayLike | None", "None", "M x 3 into uvs; None: uvs go with positions")
             .keyword("normals", "npt.ArrayLike | None", "None", "L x 3, of any length > 0")
             .keyword("normal_triangles", "npt.ArrayLike | None", "None",
                      "M x 3 into normals; None: they go with positions")
             .returns("Mesh")
             .raises("InvalidInput naming the row"),
         [](const py::object& positions, const py::object& triangles, const py::kwargs& kwargs) {
           Keywords keywords("mesh_from_arrays", kwargs);
           Mesh mesh = mesh_from(positions, triangles, keywords);
           keywords.finish();
           return kept(std::move(mesh));
         });
}

}  // namespace patinate::python
