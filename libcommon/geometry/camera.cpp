#include "patinate/geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

// Far beyond any lens, and near enough that squares and quotients of them are numbers.
constexpr double kShortestFocal = 1e-3,
                 kLongestFocal = 1e6;            // In longer sides of the picture: 179.9 degrees, and 0.2 arc seconds.
constexpr double kFarthestPrincipalPoint = 1e4;  // Likewise: a picture may be cut from a far larger one.
constexpr double kLargestDistortion = 1e12;      // k3 grows with the sixth power of the focal length.
constexpr double kFarthest = 1e15;

[[noreturn]] void fail(const std::string& what, const std::string& expected) {
  throw InvalidInput("camera: " + what + "; " + expected);
}

void check_parameters(const CameraParameters& p) {
  constexpr int kMaxSide = 65536;
  if (p.width < 1 || p.height < 1 || p.width > kMaxSide || p.height > kMaxSide) {
    fail("a picture of " + size_text(p.width, p.height) + " is out of range", "use 1 to 65536 pixels");
  }
  const double side = std::max(p.width, p.height);
  const auto is_focal = [&](double f) { return f >= side * kShortestFocal && f <= side * kLongestFocal; };
  if (!is_focal(p.fx) || !is_focal(p.fy)) {
    fail("focal lengths " + number_text(p.fx) + ", " + number_text(p.fy) + " are out of range",
         "use " + short_number_text(side * kShortestFocal) + " to " + short_number_text(side * kLongestFocal) +
             ", in pixels, for a picture of " + size_text(p.width, p.height));
  }
  const auto is_near = [&](double c) { return std::abs(c) <= side * kFarthestPrincipalPoint; };
  if (!is_near(p.cx) || !is_near(p.cy))
    fail("the principal point " + number_text(p.cx) + ", " + number_text(p.cy) + " is out of range",
         "give two numbers of pixels");
  if (!std::all_of(p.distortion.begin(), p.distortion.end(),
                   [](double d) { return std::abs(d) <= kLargestDistortion; })) {
    fail("the distortion is out of range", "give k1 k2 p1 p2 k3");
  }
  if (!(p.translation.array().abs() <= kFarthest).all()) fail("the translation is out of range", "give three numbers");
  constexpr double kTolerance = 1e-6;
  const Eigen::Matrix3d off = p.rotation * p.rotation.transpose() - Eigen::Matrix3d::Identity();
  if (!(off.cwiseAbs().maxCoeff() <= kTolerance))
    fail("the rotation is not orthonormal", "give a rotation matrix to six digits or more");
  if (!(p.rotation.determinant() > 0))
    fail("the rotation mirrors (determinant -1)", "give a right-handed rotation matrix");
}

double polynomial(const std::vector<double>& coefficients, double s) {
  double sum = 0.0;
  for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) sum = sum * s + *c;
  return sum;
}

/// Positive roots of a + b s + c s^2, ascending.
std::vector<double> positive_roots(double a, double b, double c) {
  std::vector<double> roots;
  if (c == 0.0) {
    if (b != 0.0) roots.push_back(-a / b);
  } else if (const double inside = b * b - 4.0 * a * c; inside >= 0.0) {
    const double q = -0.5 * (b + std::copysign(std::sqrt(inside), b));
    roots.push_back(q / c);
    if (q != 0.0) roots.push_back(a / q);
  }
  roots.erase(std::remove_if(roots.begin(), roots.end(), [](double s) { return !(s > 0.0 && std::isfinite(s)); }),
              roots.end());
  std::sort(roots.begin(), roots.end());
  return roots;
}

/// Least s = r^2 at which d/dr of r (1 + k1 r^2 + k2 r^4 + k3 r^6) is no longer positive; infinite when there is none.
double find_max_radius2(double k1, double k2, double k3) {
  const std::vector<double> slope{1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3};
  double low = 0.0;
  std::vector<double> ends =
      positive_roots(slope[1], 2.0 * slope[2], 3.0 * slope[3]);  // Between them it rises or falls.
  constexpr double kFar = 1e12;
  ends.push_back(kFar);
  for (double high : ends) {
    if (!(polynomial(slope, high) > 0.0)) {
      for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (low + high);
        (polynomial(slope, middle) > 0.0 ? low : high) = middle;
      }
      return low;
    }
    low = high;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

Camera::Camera(const CameraParameters& parameters) : parameters_(parameters) {
  check_parameters(parameters);
  // One that is orthonormal to rounding stays as it is: a camera made of another's parameters is the same camera.
  constexpr double kRounding = 4e-15;
  const Eigen::Matrix3d& r = parameters.rotation;
  if ((r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRounding) {
    parameters_.rotation = nearest_orthonormal(r);
  }
  center_ = -(parameters_.rotation.transpose() * parameters_.translation);
  const auto& d = parameters_.distortion;
  max_radius2_ = find_max_radius2(d[0], d[1], d[4]);
}

Vec2 Camera::distort(const Vec2& x) const {
  const auto& [k1, k2, p1, p2, k3] = parameters_.distortion;
  const double r2 = x.squaredNorm(), xy = x.x() * x.y();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x.x() * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * x.x() * x.x()),
          x.y() * radial + p1 * (r2 + 2.0 * x.y() * x.y()) + 2.0 * p2 * xy};
}

Eigen::Matrix2d Camera::distort_slope(const Vec2& x) const {
  const auto& [k1, k2, p1, p2, k3] = parameters_.distortion;
  const double r2 = x.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double radial_slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));  // d radial / d(r2), twice.
  Eigen::Matrix2d j = radial * Eigen::Matrix2d::Identity() + radial_slope * (x * x.transpose());
  const double mixed = 2.0 * (p1 * x.x() + p2 * x.y());
  j(0, 0) += 2.0 * p1 * x.y() + 6.0 * p2 * x.x();
  j(0, 1) += mixed;
  j(1, 0) += mixed;
  j(1, 1) += 6.0 * p1 * x.y() + 2.0 * p2 * x.x();
  return j;
}

std::optional<Vec2> Camera::project(const Vec3& in_world) const {
  const Vec3 p = parameters_.rotation * in_world + parameters_.translation;
  if (!(p.z() > 0.0)) return std::nullopt;
  const Vec2 x(p.x() / p.z(), p.y() / p.z());
  if (!(x.squaredNorm() < max_radius2_)) return std::nullopt;
  const Vec2 seen = distort(x);
  return Vec2(parameters_.fx * seen.x() + parameters_.cx, parameters_.fy * seen.y() + parameters_.cy);
}

std::optional<CameraRay> Camera::ray(const Vec2& pixel) const {
  const CameraParameters& c = parameters_;
  const Vec2 seen((pixel.x() - c.cx) / c.fx, (pixel.y() - c.cy) / c.fy);
  if (!seen.allFinite()) return std::nullopt;  // Half of infinity is infinite: it would never come within the lens.
  const auto error_px = [&](const Vec2& x) {
    const Vec2 off = distort(x) - seen;
    return x.squaredNorm() < max_radius2_ ? std::hypot(c.fx * off.x(), c.fy * off.y())
                                          : std::numeric_limits<double>::infinity();
  };
  constexpr double kTolerancePx = 1e-9;
  constexpr int kMaxSteps = 60, kMaxHalvings = 40;
  Vec2 x = seen;
  while (x.squaredNorm() >= max_radius2_) x *= 0.5;
  double error = error_px(x);
  for (int step = 0; step < kMaxSteps && error > kTolerancePx; ++step) {
    Vec2 move = distort_slope(x).inverse() * (seen - distort(x));
    if (!move.allFinite()) return std::nullopt;
    double next = error_px(x + move);
    for (int i = 0; i < kMaxHalvings && !(next < error); ++i) {
      move *= 0.5;
      next = error_px(x + move);
    }
    if (!(next < error)) break;
    x += move;
    error = next;
  }
  if (!(error <= kTolerancePx)) return std::nullopt;
  return CameraRay{center_, (c.rotation.transpose() * Vec3(x.x(), x.y(), 1.0)).normalized()};
}

Camera Camera::scaled(double factor) const {
  if (!(factor > 0 && std::isfinite(factor))) fail("a scale of " + number_text(factor) + " is out of range", "use > 0");
  CameraParameters p = parameters_;
  p.translation *= factor;
  return Camera(p);
}

std::string Camera::text() const {
  const CameraParameters& p = parameters_;
  std::string text = size_text(p.width, p.height);
  const auto add = [&text](double v) { text += " " + number_text(v); };
  for (double v : {p.fx, p.fy, p.cx, p.cy}) add(v);
  for (double v : p.distortion) add(v);
  for (Eigen::Index i = 0; i < 9; ++i) add(p.rotation(i / 3, i % 3));
  for (Eigen::Index i = 0; i < 3; ++i) add(p.translation(i));
  return text;
}

}  // namespace patinate
