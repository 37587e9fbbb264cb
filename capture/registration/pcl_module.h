/// \file
/// What the module `patinate-pcl` does: PCL's registration methods. They are kept for comparison only, so that the
/// module is loaded when one is asked for (libcommon/core/module.h). Inside of registration only.
#pragma once

#include <array>
#include <vector>

namespace patinate::capture {

/// Two clouds and where the search begins. Coordinates are floats, as PCL has them.
struct PclTask {
  enum class Method { Point, Plane, Generalized };
  Method method = Method::Point;
  std::vector<std::array<float, 3>> target, source;
  std::array<float, 16> start{};  ///< target_from_source, column by column.
  double gate = 0.0;              ///< Largest distance of partners; > 0.
  int num_neighbors = 20;         ///< Number of neighbors of a point, for its normal (Plane).
  int max_iterations = 0;
};

/// Raise the number in kPclEntry with every change of this class or of PclTask.
class PclModule {
 public:
  virtual ~PclModule() = default;
  /// @returns target_from_source, column by column; NaN where PCL has lost itself.
  [[nodiscard]] virtual std::array<float, 16> align(const PclTask& task) = 0;
};

/// The module's function that gives it: `PclModule* patinate_pcl_1()`.
inline constexpr const char* kPclEntry = "patinate_pcl_1";

}  // namespace patinate::capture
