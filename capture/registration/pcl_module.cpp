// The module `patinate-pcl`: see pcl_module.h.
#include "capture/registration/pcl_module.h"

#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>

#include "capture/registration/pcl_alignment.inl"

namespace patinate::capture {

namespace {

class Pcl final : public PclModule {
 public:
  [[nodiscard]] std::array<float, 16> align(const PclTask& task) override {
    if (task.method == PclTask::Method::Plane) return align_planes(task);
    const auto target = pcl_cloud<pcl::PointXYZ>(task.target), source = pcl_cloud<pcl::PointXYZ>(task.source);
    if (task.method == PclTask::Method::Point) {
      pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
      return run_pcl<pcl::PointXYZ>(icp, target, source, task);
    }
    pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
    return run_pcl<pcl::PointXYZ>(icp, target, source, task);
  }
};

}  // namespace

}  // namespace patinate::capture

extern "C" [[gnu::visibility("default")]] patinate::capture::PclModule* patinate_pcl_1() {
  static patinate::capture::Pcl module;
  return &module;
}
