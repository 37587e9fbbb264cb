#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "datasets_synthetic/curve2.h"
#include "datasets_synthetic/smooth_noise.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {

namespace {

constexpr double kDesignHeight = 220.0;  // The numbers below are mm at this height.
constexpr double kBelly = 62.0;
constexpr double kChartGutter = 3.0;  // Between charts.
constexpr int kRingBase = 10;         // Points of a ring: this times a power of two.

enum class ChartKind { Strip, DiscOutward, DiscInward };

// A piece of the profile, from one control point to another, that makes one chart.
struct Section {
  int first, last;
  ChartKind kind;
  double fineness;  // Divides the length of edges.
};

// From the middle of the bottom up to the tip; (radius, height).
const std::vector<Vec2>& profile_points() {
  static const std::vector<Vec2> points = {{0, 0},     {19, 0},     {36, 0},                             // 0-2 bottom
                                           {39.5, 2},  {39.5, 7},   {36.5, 9.5}, {33, 10.5},  {29, 13},  // 3-7 foot
                                           {22, 19},   {19.5, 26},  {20, 29},    {23.5, 31},  {24, 34},
                                           {21, 37},   {23, 40},    {30, 44.5},  // 8-15 stem with bead
                                           {47, 57},   {57, 73},    {61.5, 92},  {62.5, 96},  {62.6, 110},
                                           {61, 122},  {58, 129},   {46, 141},    // 16-23 belly
                                           {36, 147},  {29.5, 153}, {28.5, 159},  // 24-26 shoulder, neck
                                           {31, 165},  {36, 168},   {37.5, 171}, {35.5, 174}, {32, 175},
                                           {30, 178},  {26, 185},                 // 27-33 rim, lid
                                           {18, 190},  {10, 193.5}, {7.5, 196},   // 34-36 top of the lid
                                           {8, 199},   {11, 203},   {11.5, 207},  // 37-39 finial
                                           {9.5, 212}, {5, 217.5},  {0, 220}};    // 40-42 tip
  return points;
}

constexpr std::array<Section, 10> kSections = {{{0, 2, ChartKind::DiscOutward, 1.0},
                                                {2, 7, ChartKind::Strip, 1.4},
                                                {7, 15, ChartKind::Strip, 1.3},
                                                {15, 16, ChartKind::Strip, 1.4},
                                                {16, 23, ChartKind::Strip, 1.6},
                                                {23, 26, ChartKind::Strip, 1.2},
                                                {26, 33, ChartKind::Strip, 1.3},
                                                {33, 36, ChartKind::DiscInward, 1.3},
                                                {36, 39, ChartKind::Strip, 1.3},
                                                {39, 42, ChartKind::DiscInward, 1.3}}};

// Carving of the belly at a height and an angle, along the outward normal.
double carving(const SculptureOptions& o, double y, double angle) {
  double depth = 0.0;
  if (o.num_flutes > 0) {  // Gadroons: round ribs with narrow valleys that fade out at both ends.
    const double window = smooth_step(43.0, 52.0, y) * (1.0 - smooth_step(84.0, 91.0, y));
    const double turned = angle - o.twist_deg * std::numbers::pi / 180.0 * (y - 43.0) / 48.0;
    depth += window * o.flute_depth * kBelly *
             (std::pow(std::pow(std::cos(0.5 * o.num_flutes * turned), 2) + 0.01, 0.25) - 1.0);
  }
  // A guilloche: two ropes that wind round each other, with a boss in every eye, between two fillets.
  constexpr double kMiddle = 109.0, kHalf = 13.0;
  constexpr int kEyes = 16;
  const double t = (y - kMiddle) / kHalf;
  const auto rope = [&](double phase) {
    const double slope = 0.62 * 0.5 * kEyes * kHalf / kBelly * std::cos(0.5 * kEyes * angle + phase);
    const double off = (t - 0.62 * std::sin(0.5 * kEyes * angle + phase)) / std::hypot(1.0, slope);
    const double u = off / 0.26;
    return std::abs(u) < 1.0 ? std::pow(1.0 - u * u, 0.75) : 0.0;
  };
  const double around =
      std::remainder(0.5 * kEyes * angle - 0.5 * std::numbers::pi, std::numbers::pi) / (0.5 * kEyes) * kBelly / kHalf;
  const double eye = std::hypot(t, around) / 0.30;
  const double boss = eye < 1.0 ? std::sqrt(1.0 - eye * eye) : 0.0;
  const double fillet = 0.7 * (1.0 - smooth_step(0.06, 0.14, std::abs(std::abs(t) - 1.08)));
  const double ground = -0.35 * (1.0 - smooth_step(0.95, 1.02, std::abs(t)));
  return depth + o.relief * kBelly * (std::max({rope(0.0), rope(std::numbers::pi), boss, fillet}) + ground);
}

// A rectangle of the atlas, in mm; `place` is filled by pack().
struct Chart {
  double width = 0.0, height = 0.0;
  Vec2 place = Vec2::Zero();
  int first_uv = 0, end_uv = 0;
};

struct Builder {
  Mesh mesh;
  std::vector<Chart> charts;

  int add_position(const Vec3& p) {
    mesh.positions.push_back(p);
    return static_cast<int>(mesh.positions.size()) - 1;
  }
  int add_uv(const Vec2& uv) {
    mesh.uvs.push_back(uv);
    return static_cast<int>(mesh.uvs.size()) - 1;
  }
  void add_triangle(const Triangle& corners, const Triangle& uvs) {
    mesh.triangles.push_back(corners);
    mesh.uv_triangles.push_back(uvs);
    mesh.triangle_surface.push_back(0);
  }
  void begin_chart(double width, double height) {
    charts.emplace_back();
    charts.back().width = width;
    charts.back().height = height;
    charts.back().first_uv = static_cast<int>(mesh.uvs.size());
  }
  void end_chart() { charts.back().end_uv = static_cast<int>(mesh.uvs.size()); }
};

// A ring of `count` positions from `position`, and its count + 1 UVs in the current chart; count 1 is a pole.
struct Ring {
  int count = 0;
  int position = 0;
  int uv = 0;
  [[nodiscard]] int corner(int i) const { return position + i % count; }
};

// Triangles between a ring and the next one on the way up, seen from outside: angle to the right, the next ring above.
// The counts are equal, or one is twice the other, or one is a pole.
void join(Builder& b, const Ring& low, const Ring& high) {
  const auto add = [&](const Ring& r0, int i0, const Ring& r1, int i1, const Ring& r2, int i2) {
    b.add_triangle({r0.corner(i0), r1.corner(i1), r2.corner(i2)}, {r0.uv + i0, r1.uv + i1, r2.uv + i2});
  };
  const int n = std::min(low.count, high.count);
  for (int i = 0; i < std::max(low.count, high.count) && (low.count == 1 || high.count == 1); ++i) {
    if (low.count == 1)
      add(low, 0, high, i + 1, high, i);
    else
      add(low, i, low, i + 1, high, 0);
  }
  if (n == 1) return;
  for (int i = 0; i < n; ++i) {
    if (low.count == high.count) {
      add(low, i, low, i + 1, high, i + 1);
      add(low, i, high, i + 1, high, i);
    } else if (high.count == 2 * n) {
      add(low, i, low, i + 1, high, 2 * i + 1);
      add(low, i, high, 2 * i + 1, high, 2 * i);
      add(low, i + 1, high, 2 * i + 2, high, 2 * i + 1);
    } else {
      add(low, 2 * i, low, 2 * i + 1, high, i);
      add(low, 2 * i + 1, high, i + 1, high, i);
      add(low, 2 * i + 1, low, 2 * i + 2, high, i + 1);
    }
  }
}

// Points of a ring of radius r, not more than twice or less than half as many as `before`.
int ring_count(double r, double edge, int before) {
  int count = kRingBase;
  while (count * edge < 2.0 * std::numbers::pi * r && count < kRingBase << 10) count *= 2;
  return before > 1 ? std::clamp(count, before / 2, before * 2) : count;
}

using RingMaker = std::function<void(Ring&, double s)>;

// One section of a tube or profile as one chart: rings along s, sharing the positions of `previous`.
void add_section(Builder& b, double s0, double s1, double edge, ChartKind kind, double mean_radius,
                 const RingMaker& make_positions, const std::function<double(double)>& radius, Ring& previous) {
  const double length = s1 - s0;
  const double side = kind == ChartKind::Strip ? 0.0 : 2.0 * length;
  const bool is_annulus = kind == ChartKind::DiscInward && radius(s1) > 1e-9;
  const double inner = is_annulus ? radius(s1) : 0.0;
  b.begin_chart(kind == ChartKind::Strip ? 2.0 * std::numbers::pi * mean_radius : side + 2.0 * inner,
                kind == ChartKind::Strip ? length : side + 2.0 * inner);
  const Vec2 middle(0.5 * b.charts.back().width, 0.5 * b.charts.back().height);
  const auto add_uvs = [&](Ring& ring, double s) {
    ring.uv = static_cast<int>(b.mesh.uvs.size());
    for (int i = 0; i <= ring.count; ++i) {
      const double f = static_cast<double>(i) / ring.count;
      const double a = 2.0 * std::numbers::pi * f;
      if (kind == ChartKind::Strip) b.add_uv({f * 2.0 * std::numbers::pi * mean_radius, s - s0});
      if (kind == ChartKind::DiscOutward) b.add_uv(middle + (s - s0) * Vec2(std::cos(-a), std::sin(-a)));
      if (kind == ChartKind::DiscInward) b.add_uv(middle + (inner + s1 - s) * Vec2(std::cos(a), std::sin(a)));
      if (ring.count == 1) break;
    }
  };
  const int rows = std::max(2, static_cast<int>(std::ceil(length / edge)));
  for (int j = 0; j <= rows; ++j) {
    const double s = s0 + length * j / rows;
    Ring ring = previous;
    if (j > 0 || previous.count == 0) {
      ring.count = radius(s) > 1e-9 ? ring_count(radius(s), edge, previous.count) : 1;
      make_positions(ring, s);
    }
    add_uvs(ring, s);
    if (j > 0) join(b, previous, ring);
    previous = ring;
  }
  b.end_chart();
}

void add_urn(Builder& b, const SculptureOptions& o, double edge) {
  const Curve2 profile(profile_points());
  const auto radius = [&](double s) { return std::max(0.0, profile.at(s).x()); };
  const RingMaker make_ring = [&](Ring& ring, double s) {
    const Vec2 p = profile.at(s), t = profile.tangent(s);
    const Vec2 normal(t.y(), -t.x());
    ring.position = static_cast<int>(b.mesh.positions.size());
    for (int i = 0; i < ring.count; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / ring.count;
      const Vec2 q = p + carving(o, p.y(), angle) * normal;
      b.add_position(ring.count == 1 ? Vec3(0.0, p.y(), 0.0)
                                     : Vec3(q.x() * std::sin(angle), q.y(), q.x() * std::cos(angle)));
    }
  };
  Ring previous;
  for (const Section& section : kSections) {
    const double s0 = profile.length_at(section.first), s1 = profile.length_at(section.last);
    double low = 1e300, high = 0.0;
    for (int k = 0; k <= 64; ++k) {
      low = std::min(low, radius(s0 + (s1 - s0) * k / 64));
      high = std::max(high, radius(s0 + (s1 - s0) * k / 64));
    }
    add_section(b, s0, s1, edge / section.fineness, section.kind, std::sqrt(low * high), make_ring, radius, previous);
  }
}

// A bent tube from inside the belly to inside the neck, closed by flat discs.
void add_handle(Builder& b, double side, double edge) {
  const Curve2 path({{52, 118}, {64, 124}, {75, 136}, {78, 151}, {71, 164}, {57, 169}, {42, 166}, {24, 158}});
  const double length = path.length();
  const double end_radius = 7.0;
  const auto radius = [&](double s) {
    if (s < 0.0) return end_radius + s;
    if (s > length) return end_radius + length - s;
    const double f = 2.0 * s / length - 1.0;
    return 5.4 + (end_radius - 5.4) * f * f;
  };
  const RingMaker make_ring = [&](Ring& ring, double s) {
    const Vec2 p = path.at(s), t = path.tangent(std::clamp(s, 0.0, length));
    ring.position = static_cast<int>(b.mesh.positions.size());
    for (int i = 0; i < ring.count; ++i) {
      // The seam runs along the inside, a shallow groove along the back.
      const double angle = 2.0 * std::numbers::pi * i / ring.count;
      const double r = ring.count == 1 ? 0.0 : radius(s);
      const double off = -std::cos(angle) * r * (1.0 - 0.28 * std::exp(-std::pow((angle - std::numbers::pi) / 0.5, 2)));
      const Vec2 q = p + off * Vec2(t.y(), -t.x());
      b.add_position({side * q.x(), q.y(), side * std::sin(angle) * 1.15 * r});
    }
  };
  Ring previous;
  const double fine = edge / 1.3;
  add_section(b, -end_radius, 0.0, fine, ChartKind::DiscOutward, end_radius, make_ring, radius, previous);
  add_section(b, 0.0, length, fine, ChartKind::Strip, radius(0.25 * length), make_ring, radius, previous);
  add_section(b, length, length + end_radius, fine, ChartKind::DiscInward, end_radius, make_ring, radius, previous);
}

// Puts each chart as low as the ones below let it lie, in a square of the given side (mm, like all here in whole
// steps). False if they do not fit.
bool place_charts(std::vector<Chart>& charts, const std::vector<std::size_t>& order, int side) {
  std::vector<int> skyline(static_cast<std::size_t>(side), 0);
  for (const std::size_t i : order) {
    const int width = static_cast<int>(std::ceil(charts[i].width + kChartGutter));
    const int height = static_cast<int>(std::ceil(charts[i].height + kChartGutter));
    int best = side, best_x = -1;
    for (int x = 0; x + width <= side; ++x) {
      const int level = *std::max_element(skyline.begin() + x, skyline.begin() + x + width);
      if (level < best) best = level, best_x = x;
    }
    if (best_x < 0 || best + height > side) return false;
    std::fill(skyline.begin() + best_x, skyline.begin() + best_x + width, best + height);
    charts[i].place = Vec2(best_x + 0.5 * kChartGutter, best + 0.5 * kChartGutter);
  }
  return true;
}

void pack(Builder& b) {
  std::vector<std::size_t> order(b.charts.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return b.charts[i].width > b.charts[j].width; });
  int side = 100;
  while (!place_charts(b.charts, order, side)) ++side;
  for (const Chart& chart : b.charts) {
    for (int i = chart.first_uv; i < chart.end_uv; ++i) {
      Vec2& uv = b.mesh.uvs[i];
      uv = (chart.place + uv) / side;
    }
  }
}

}  // namespace

void describe(OptionVisitor& v, SculptureOptions& o) {
  v.visit({"height", "Height", "mm", above(0)}, o.height_mm);
  v.visit({"resolution", "Height divided by the length of an edge", "", between(24, 400)}, o.resolution);
  v.visit({"num_flutes", "Ribs around the lower belly", "", between(0, 60)}, o.num_flutes);
  v.visit({"flute_depth", "Depth between ribs, in radii of the belly", "", between(0, 0.08)}, o.flute_depth);
  v.visit({"relief", "Height of the carved band, in radii of the belly", "", between(0, 0.06)}, o.relief);
  v.visit({"twist", "How far the ribs wind around", "deg", between(-90, 90)}, o.twist_deg);
}

Mesh sculpture(const SculptureOptions& options) {
  check_ranges(options);
  Builder builder;
  builder.mesh.surfaces = {{"urn", "clay"}};
  const double edge = kDesignHeight / options.resolution;
  add_urn(builder, options, edge);
  add_handle(builder, 1.0, edge);
  add_handle(builder, -1.0, edge);
  pack(builder);
  scale_mesh(builder.mesh, options.height_mm / kDesignHeight);
  return with_normals(std::move(builder.mesh));
}

}  // namespace patinate::datasets
