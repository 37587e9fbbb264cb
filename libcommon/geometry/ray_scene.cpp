#include "libcommon/geometry/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "patinate/core/error.h"

namespace patinate {

namespace {

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct ReleaseGeometry {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using Scene = std::unique_ptr<RTCSceneTy, ReleaseScene>;
using Geometry = std::unique_ptr<RTCGeometryTy, ReleaseGeometry>;

void throw_on_error(const Device& device) {
  const RTCError error = rtcGetDeviceError(device.get());
  if (error != RTC_ERROR_NONE) {
    throw CannotComplete(error == RTC_ERROR_OUT_OF_MEMORY ? "ray casting: out of memory"
                                                          : "ray casting: Embree cannot build its scene");
  }
}

}  // namespace

struct RayScene::Impl {
  Device device;
  Scene scene;
  Vec3 center = Vec3::Zero();  ///< Subtracted before coordinates become float.

  [[nodiscard]] RTCRay ray(const Vec3& origin, const Vec3& direction, double from, double to) const {
    const Eigen::Vector3f o = (origin - center).cast<float>(), d = direction.cast<float>();
    RTCRay r{};
    r.org_x = o.x(), r.org_y = o.y(), r.org_z = o.z();
    r.dir_x = d.x(), r.dir_y = d.y(), r.dir_z = d.z();
    r.tnear = static_cast<float>(from);
    r.tfar = static_cast<float>(to);
    r.mask = 0xffffffffu;
    return r;
  }

  [[nodiscard]] bool is_blocked(RTCRay query) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene.get(), &context, &query);
    return query.tfar < 0.0F;
  }
};

#ifdef __SANITIZE_THREAD__
/// The thread sanitizer sees nothing of how Embree's own threads wait for one another.
constexpr const char* kDeviceSettings = "threads=1";
#else
constexpr const char* kDeviceSettings = nullptr;
#endif

RayScene::RayScene(const Mesh& mesh) : impl_(std::make_unique<Impl>()) {
  impl_->device.reset(rtcNewDevice(kDeviceSettings));
  if (!impl_->device) throw CannotComplete("ray casting: Embree cannot start");
  impl_->scene.reset(rtcNewScene(impl_->device.get()));
  rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(impl_->scene.get(), RTC_BUILD_QUALITY_HIGH);
  if (!mesh.triangles.empty()) {
    impl_->center = bounding_box(mesh).center();
    const Geometry geometry(rtcNewGeometry(impl_->device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
    throw_on_error(impl_->device);
    for (const Vec3& p : mesh.positions) {
      for (Eigen::Index c = 0; c < 3; ++c) *vertices++ = static_cast<float>(p[c] - impl_->center[c]);
    }
    for (const Triangle& t : mesh.triangles) {
      for (int corner : t) *indices++ = static_cast<unsigned>(corner);
    }
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(impl_->scene.get(), geometry.get());
  }
  rtcCommitScene(impl_->scene.get());
  throw_on_error(impl_->device);
}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

std::optional<RayHit> RayScene::first_hit(const Vec3& origin, const Vec3& direction, double min_distance,
                                          double max_distance) const {
  RTCRayHit query{};
  query.ray = impl_->ray(origin, direction, min_distance, max_distance);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return RayHit{.triangle = static_cast<int>(query.hit.primID),
                .b1 = static_cast<double>(query.hit.u),
                .b2 = static_cast<double>(query.hit.v),
                .distance = static_cast<double>(query.ray.tfar)};
}

bool RayScene::is_blocked(const Vec3& from, const Vec3& to, double epsilon) const {
  const double length = (to - from).norm();
  if (!(length > 2.0 * epsilon)) return false;
  return impl_->is_blocked(impl_->ray(from, (to - from) / length, epsilon, length - epsilon));
}

bool RayScene::is_blocked_along(const Vec3& origin, const Vec3& direction, double max_distance) const {
  return impl_->is_blocked(impl_->ray(origin, direction, 0.0, std::min(max_distance, 1e30)));
}

namespace {

/// Up to 8 rays that are asked for at once.
class RayPacket {
 public:
  explicit RayPacket(std::size_t size) : size_(size) {
    if (size > kWidth) throw InvalidInput("ray casting: at most 8 rays at a time");
  }
  void set(std::size_t i, const Eigen::Vector3f& o, const Eigen::Vector3f& d, double max_distance) {
    valid_[i] = -1;
    rays_.org_x[i] = o.x(), rays_.org_y[i] = o.y(), rays_.org_z[i] = o.z();
    rays_.dir_x[i] = d.x(), rays_.dir_y[i] = d.y(), rays_.dir_z[i] = d.z();
    rays_.tfar[i] = static_cast<float>(std::min(max_distance, 1e30));
    rays_.mask[i] = 0xffffffffu;
  }
  /// Bit i is set where something lies on ray i.
  [[nodiscard]] unsigned blocked(RTCScene scene) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded8(valid_.data(), scene, &context, &rays_);
    unsigned blocked = 0;
    for (std::size_t i = 0; i < size_; ++i) blocked |= rays_.tfar[i] < 0.0F ? 1u << i : 0u;
    return blocked;
  }

 private:
  static constexpr std::size_t kWidth = 8;
  std::size_t size_;
  alignas(32) std::array<int, kWidth> valid_{};
  alignas(32) RTCRay8 rays_{};
};

}  // namespace

unsigned RayScene::blocked_of_8(std::span<const Vec3> origins, const Vec3& direction, double max_distance) const {
  RayPacket packet(origins.size());
  const Eigen::Vector3f d = direction.cast<float>();
  for (std::size_t i = 0; i < origins.size(); ++i)
    packet.set(i, (origins[i] - impl_->center).cast<float>(), d, max_distance);
  return packet.blocked(impl_->scene.get());
}

unsigned RayScene::blocked_of_8(const Vec3& origin, std::span<const Vec3> directions,
                                std::span<const double> max_distances) const {
  RayPacket packet(directions.size());
  const Eigen::Vector3f o = (origin - impl_->center).cast<float>();
  for (std::size_t i = 0; i < directions.size(); ++i) packet.set(i, o, directions[i].cast<float>(), max_distances[i]);
  return packet.blocked(impl_->scene.get());
}

}  // namespace patinate
