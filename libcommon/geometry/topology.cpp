#include "libcommon/geometry/topology.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <vector>

namespace patinate {

namespace {

using View = OpenMesh::TriMesh_ArrayKernelT<>;

/// Vertices keep the indices of positions; triangles that would make an edge or vertex complex are counted, not added.
View make_view(const Mesh& mesh, int& num_excluded) {
  omerr().disable();  // It prints a line for each complex edge; we count them.
  View view;
  std::vector<View::VertexHandle> vertices;
  vertices.reserve(mesh.positions.size());
  for (const Vec3& p : mesh.positions) {
    vertices.push_back(
        view.add_vertex(View::Point(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()))));
  }
  for (const Triangle& t : mesh.triangles) {
    const auto corner = [&](std::size_t k) { return vertices[t[k]]; };
    if (!view.add_face(corner(0), corner(1), corner(2)).is_valid()) ++num_excluded;
  }
  return view;
}

int count_boundary_loops(const View& view) {
  std::vector<bool> is_seen(view.n_halfedges(), false);
  int loops = 0;
  for (const auto halfedge : view.halfedges()) {
    if (!view.is_boundary(halfedge) || is_seen[halfedge.idx()]) continue;
    ++loops;
    for (auto h = View::HalfedgeHandle(halfedge); !is_seen[h.idx()]; h = view.next_halfedge_handle(h)) {
      is_seen[h.idx()] = true;
    }
  }
  return loops;
}

int count_parts(const View& view) {
  std::vector<bool> is_seen(view.n_faces(), false);
  std::vector<View::FaceHandle> open;
  int parts = 0;
  for (const auto face : view.faces()) {
    if (is_seen[face.idx()]) continue;
    ++parts;
    is_seen[face.idx()] = true;
    open.assign(1, face);
    while (!open.empty()) {
      const View::FaceHandle f = open.back();
      open.pop_back();
      for (auto it = view.cff_iter(f); it.is_valid(); ++it) {
        if (is_seen[it->idx()]) continue;
        is_seen[it->idx()] = true;
        open.push_back(*it);
      }
    }
  }
  return parts;
}

}  // namespace

MeshTopology mesh_topology(const Mesh& mesh) {
  MeshTopology topology;
  const View view = make_view(mesh, topology.num_nonmanifold_triangles);
  topology.num_parts = count_parts(view);
  topology.num_boundary_loops = count_boundary_loops(view);
  int num_used = 0;
  for (const auto vertex : view.vertices()) num_used += view.is_isolated(vertex) ? 0 : 1;
  topology.euler_characteristic = num_used - static_cast<int>(view.n_edges()) + static_cast<int>(view.n_faces());
  return topology;
}

}  // namespace patinate
