#include "libcommon/output/microfacet.h"

#include <algorithm>
#include <vector>

#include "libcommon/output/sampling.h"

namespace patinate {

namespace {

constexpr int kTableSide = 32;
constexpr int kTableSamples = 256;
constexpr double kMinCosine = 1e-3;

// Smith's masking of one direction: 2 cos / (cos + sqrt(a^2 + (1 - a^2) cos^2)).
double masking(double alpha, double cosine) {
  const double a2 = alpha * alpha;
  return 2.0 * cosine / (cosine + std::sqrt(a2 + (1.0 - a2) * cosine * cosine));
}

double place_cosine(int i) { return std::max(kMinCosine, static_cast<double>(i) / (kTableSide - 1)); }

LobeEnergy integrated_energy(double roughness, double cos_view) {
  const Vec3 view(std::sqrt(1.0 - cos_view * cos_view), 0.0, cos_view);
  const Lobe lobe(Vec3::UnitZ(), view, roughness);
  LobeEnergy energy;
  for (int i = 0; i < kTableSamples; ++i) {
    const Lobe::Value v = lobe.value(lobe.sample({(i + 0.5) / kTableSamples, sequence_point(i, {0.0, 0.0}).y()}));
    if (!(v.pdf > 0.0)) continue;
    const double share = v.shape / v.pdf / kTableSamples, grazing = fresnel(0.0, v.half_cosine);
    energy.scale += (1.0 - grazing) * share;
    energy.bias += grazing * share;
  }
  return energy;
}

std::vector<LobeEnergy> make_table() {
  std::vector<LobeEnergy> table;
  for (int j = 0; j < kTableSide; ++j) {
    const double roughness = std::max(0.05, static_cast<double>(j) / (kTableSide - 1));
    for (int i = 0; i < kTableSide; ++i) table.push_back(integrated_energy(roughness, place_cosine(i)));
  }
  return table;
}

}  // namespace

double fresnel(double f0, double cosine) {
  const double m = 1.0 - std::clamp(cosine, 0.0, 1.0);
  return f0 + (1.0 - f0) * m * m * m * m * m;
}

LobeEnergy lobe_energy(double roughness, double cos_view) {
  static const std::vector<LobeEnergy> table = make_table();
  const double x = std::clamp(cos_view, 0.0, 1.0) * (kTableSide - 1);
  const double y = std::clamp(roughness, 0.0, 1.0) * (kTableSide - 1);
  const int i = std::min(static_cast<int>(x), kTableSide - 2), j = std::min(static_cast<int>(y), kTableSide - 2);
  const auto at = [](int a, int b) { return table[b * kTableSide + a]; };
  const auto mix = [](const LobeEnergy& a, const LobeEnergy& b, double t) {
    return LobeEnergy{a.scale + t * (b.scale - a.scale), a.bias + t * (b.bias - a.bias)};
  };
  return mix(mix(at(i, j), at(i + 1, j), x - i), mix(at(i, j + 1), at(i + 1, j + 1), x - i), y - j);
}

LobeTurn lobe_turn(const Vec3& normal, const Vec3& view, const Vec3& light, double roughness) {
  const double cos_light = normal.dot(light), facing = normal.dot(view);
  if (!(cos_light > 0.0) || !(facing > 0.0)) return {};
  const double cos_view = std::max(kMinCosine, facing), alpha = roughness * roughness, a2 = alpha * alpha,
               rest = 1.0 - a2;
  const Vec3 half = (view + light).normalized();
  const double nh = std::clamp(normal.dot(half), 0.0, 1.0);
  const double d = a2 + rest * normal.cross(half).squaredNorm() * (nh > 0.0 ? 1.0 : 0.0);
  const double density = a2 / (std::numbers::pi * d * d);
  const double root_view = std::sqrt(a2 + rest * cos_view * cos_view),
               root_light = std::sqrt(a2 + rest * cos_light * cos_light);
  const double g_view = 2.0 * cos_view / (cos_view + root_view), g_light = 2.0 * cos_light / (cos_light + root_light);
  const double sum = g_view + g_light - g_view * g_light, both = g_view * g_light / sum;
  // The density falls with the squared sine, 1 - (normal . half)^2, and masking with each cosine alone.
  const double by_half = 4.0 * rest * nh / d;
  const double by_view = 2.0 * a2 / (root_view * (cos_view + root_view) * (cos_view + root_view)),
               by_light = 2.0 * a2 / (root_light * (cos_light + root_light) * (cos_light + root_light));
  const double shape = density * both / (4.0 * cos_view), scale = density / (4.0 * cos_view * sum * sum);
  LobeTurn out{.shape = shape, .by_normal = shape * by_half * half + scale * g_view * g_view * by_light * light};
  if (facing > kMinCosine) out.by_normal += (scale * g_light * g_light * by_view - shape / cos_view) * view;
  return out;
}

Lobe::Lobe(const Vec3& normal, const Vec3& view, double roughness)
    : normal_(normal), view_(view), alpha_(roughness * roughness), cos_view_(std::max(kMinCosine, normal.dot(view))) {
  tangents(normal, a_, b_);
}

Lobe::Value Lobe::value(const Vec3& light) const {
  const double cos_light = normal_.dot(light);
  if (!(cos_light > 0.0)) return {};
  const Vec3 half = (view_ + light).normalized();
  const double nh = std::clamp(normal_.dot(half), 0.0, 1.0), a2 = alpha_ * alpha_;
  // 1 - (1 - a^2) cos^2 with the sine, which keeps its digits near the peak.
  const double d = a2 + (1.0 - a2) * normal_.cross(half).squaredNorm() * (nh > 0.0 ? 1.0 : 0.0);
  const double density = a2 / (std::numbers::pi * d * d);
  const double g_view = masking(alpha_, cos_view_), g_light = masking(alpha_, cos_light);
  // Height-correlated masking of both directions [Heitz 2014].
  const double both = g_view * g_light / (g_view + g_light - g_view * g_light);
  return {.shape = density * both / (4.0 * cos_view_),
          .pdf = density * g_view / (4.0 * cos_view_),
          .half_cosine = half.dot(view_)};
}

Vec3 Lobe::sample(const Vec2& square) const {
  const Vec3 local(view_.dot(a_), view_.dot(b_), cos_view_);
  const Vec3 stretched = Vec3(alpha_ * local.x(), alpha_ * local.y(), local.z()).normalized();
  const double across = std::hypot(stretched.x(), stretched.y());
  const Vec3 t1 = across > 1e-9 ? Vec3(-stretched.y() / across, stretched.x() / across, 0.0) : Vec3(Vec3::UnitX());
  const Vec3 t2 = stretched.cross(t1);
  const Vec2 disc = disc_point(square);
  const double s = 0.5 * (1.0 + stretched.z()), x = disc.x();
  const double y = (1.0 - s) * std::sqrt(std::max(0.0, 1.0 - x * x)) + s * disc.y();
  const Vec3 cap = x * t1 + y * t2 + std::sqrt(std::max(0.0, 1.0 - x * x - y * y)) * stretched;
  const Vec3 facet = Vec3(alpha_ * cap.x(), alpha_ * cap.y(), std::max(1e-9, cap.z())).normalized();
  const Vec3 half = facet.x() * a_ + facet.y() * b_ + facet.z() * normal_;
  return (2.0 * half.dot(view_) * half - view_).normalized();
}

}  // namespace patinate
