#include <utility>

#include "patinate/capture/registration.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

/// The path of a scan, or N x 3 points.
PointCloud cloud_from(const py::object& given, const std::string& what) {
  if (py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__")) {
    const std::string path = path_from(given);
    return result_of({}, [=](const RunControl&) { return read_point_cloud(path); });
  }
  const auto rows = rows_from(given, what, 3);
  PointCloud cloud;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    const Vec3 point(rows.at(i, 0), rows.at(i, 1), rows.at(i, 2));
    if (point.allFinite()) cloud.points.push_back(point);  // Points that a scanner did not measure are NaN.
  }
  return cloud;
}

template <class Matrix>
py::array array_of_matrix(const Matrix& matrix) {
  py::array_t<double> out({matrix.rows(), matrix.cols()});
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) out.mutable_at(i, k) = matrix(i, k);
  }
  return out;
}

RigidTransform transform_from(const py::object& given) {
  const auto rows = rows_from(given, "initial", 4);
  if (rows.shape(0) != 4) throw InvalidInput("initial: expected 4 x 4");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) matrix(i, k) = rows.at(i, k);
  }
  return rigid_transform(matrix);
}

}  // namespace

void bind_register(py::module_& module) {
  define(
      module,
      FunctionText("register",
                   "Brings one scan of an object into the frame of another. Not reaching it is a status, not an error.")
          .takes("target", "npt.ArrayLike | str | os.PathLike[str]",
                 "N x 3 points (NaN: not measured), or a scan's file")
          .takes("source", "npt.ArrayLike | str | os.PathLike[str]", "What is moved")
          .keyword("initial", "npt.ArrayLike | None", "None", "4 x 4 target from source; None: searched for")
          .options<capture::RegistrationOptions>()
          .runs()
          .returns("Report",
                   "status (converged, iteration limit, too few pairs, degenerate, poor fit); target_from_source: 4 x "
                   "4; rms_residual and "
                   "median_residual in the scans' unit; overlap: share of the smaller scan; covariance: 6 x 6 of "
                   "rotation (radians) and "
                   "shift about center; unconstrained: what the shape leaves open, as text; num_pairs")
          .raises("InvalidInput on fewer than 16 points or no extent; IoError"),
      [](const py::object& target, const py::object& source, const py::kwargs& kwargs) {
        Keywords keywords("register", kwargs);
        capture::RegistrationOptions options;
        keywords.read(options);
        const py::object given = keywords.object("initial");
        const RunArguments run = keywords.run();
        keywords.finish();
        const std::optional<RigidTransform> start =
            given.is_none() ? std::nullopt : std::optional(transform_from(given));
        PointCloud to = cloud_from(target, "target"), from = cloud_from(source, "source");
        const capture::PairRegistration found =
            result_of(run, [to = std::move(to), from = std::move(from), start, options](const RunControl& control) {
              return capture::register_pair(to, from, start, options, control);
            });
        py::dict out;
        out["status"] = std::string(name_of(found.status));
        out["target_from_source"] = array_of_matrix(found.target_from_source.matrix());
        out["rms_residual"] = found.rms_residual;
        out["median_residual"] = found.median_residual;
        out["overlap"] = found.overlap;
        out["covariance"] = array_of_matrix(found.covariance);
        out["center"] = array_of_matrix(found.center.transpose()).attr("reshape")(3);
        py::list open;
        for (const capture::UnconstrainedDof& motion : found.unconstrained_dofs) open.append(text_of(motion));
        out["unconstrained"] = open;
        out["num_pairs"] = found.num_pairs;
        return out;
      });
}

}  // namespace patinate::python
