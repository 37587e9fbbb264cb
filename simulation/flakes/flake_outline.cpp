#include "simulation/flakes/flake_outline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace patinate::simulation {

namespace {

constexpr int kPasses = 8;        // Steps of up to four texels vanish.
constexpr double kShrink = 0.5;   // Taubin's lambda,
constexpr double kSwell = -0.53;  // and mu: the pass band ends at 1 / lambda + 1 / mu = 0.11.
constexpr int kStraight = 3;      // Squares.

using Square = std::array<int, 2>;

/// Squares of texels, each with the flake that has most of it.
class Squares {
 public:
  Squares(const LiftedFlakes& flakes, int step)
      : flakes_(flakes),
        step_(step),
        width_((flakes.width + step - 1) / step),
        height_((flakes.height + step - 1) / step),
        flake_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), -1) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) flake_[index(x, y)] = step == 1 ? flakes.flake[flakes.index(x, y)] : most(x, y);
    }
  }

  [[nodiscard]] std::int32_t at(int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_ ? flake_[index(x, y)] : -1;
  }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// What lies behind a side of a flake's square. @param x,y  Of the square behind it.
  void look_behind(std::int32_t flake, int chart, int x, int y, OutlineEdge& edge) const {
    const int layer = flakes_.flakes[static_cast<std::size_t>(flake)].layer;
    int num_cracked = 0;
    double open = 0.0;
    for_each_texel(x, y, [&](std::size_t i) {
      if (flakes_.chart[i] != chart) return;
      edge.is_hinge = edge.is_hinge || (flakes_.holds[i] >> layer & 1U) != 0;
      if (flakes_.cracked[i] != layer) return;
      ++num_cracked;
      open += static_cast<double>(flakes_.crack_share[i]);
    });
    constexpr double kHalf = 0.5;
    if (!edge.is_hinge && num_cracked > 0) edge.widening = kHalf * (1.0 - open / num_cracked);
  }
  /// Chart of a flake's square.
  [[nodiscard]] int chart(std::int32_t flake, int x, int y) const {
    int chart = -1;
    for_each_texel(x, y, [&](std::size_t i) {
      if (chart < 0 && flakes_.flake[i] == flake) chart = flakes_.chart[i];
    });
    return chart;
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  template <class F>
  void for_each_texel(int x, int y, F&& f) const {
    for (int ty = y * step_; ty < (y + 1) * step_; ++ty) {
      for (int tx = x * step_; tx < (x + 1) * step_; ++tx) {
        if (flakes_.is_inside(tx, ty)) f(flakes_.index(tx, ty));
      }
    }
  }
  [[nodiscard]] std::int32_t most(int x, int y) const {
    std::map<std::int32_t, int> counts;
    for_each_texel(x, y, [&](std::size_t i) { ++counts[flakes_.flake[i]]; });
    const auto most = std::max_element(counts.begin(), counts.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return most == counts.end() ? -1 : most->first;
  }

  const LiftedFlakes& flakes_;
  int step_, width_, height_;
  std::vector<std::int32_t> flake_;
};

/// Makes the outline of one flake from its squares.
class Builder {
 public:
  Builder(const Squares& squares, std::int32_t flake, int step) : squares_(squares), step_(step) {
    outline_.flake = flake;
  }

  FlakeOutline build(const std::vector<Square>& own) {
    for (const auto& [x, y] : own) {
      const std::array<int, 4> corners{corner(x, y, 0), corner(x, y, 1), corner(x, y, 2), corner(x, y, 3)};
      outline_.squares.push_back(corners);
      constexpr std::array<Square, 4> kBehind{{{-1, 0}, {0, 1}, {1, 0}, {0, -1}}};
      for (std::size_t side = 0; side < 4; ++side) {
        const int bx = x + kBehind[side][0], by = y + kBehind[side][1];
        if (squares_.at(bx, by) == outline_.flake) continue;
        OutlineEdge edge{.a = corners[side], .b = corners[(side + 1) % 4]};
        squares_.look_behind(outline_.flake, squares_.chart(outline_.flake, x, y), bx, by, edge);
        outline_.edges.push_back(edge);
      }
    }
    smooth();
    widen();
    return std::move(outline_);
  }

 private:
  /// @param which  0 = upper left, 1 = lower left, 2 = lower right, 3 = upper right. Where two squares of a flake meet
  /// at a corner alone, each has a corner of its own.
  int corner(int x, int y, int which) {
    const int cx = x + (which == 2 || which == 3 ? 1 : 0), cy = y + (which == 1 || which == 2 ? 1 : 0);
    const auto is_own = [&](int dx, int dy) { return squares_.at(cx + dx, cy + dy) == outline_.flake; };
    const bool a = is_own(-1, -1), b = is_own(0, -1), c = is_own(-1, 0), d = is_own(0, 0);
    const bool is_pinched = (a && d && !b && !c) || (b && c && !a && !d);
    const std::array<int, 3> key{cx, cy, is_pinched ? 1 + which : 0};
    const auto [found, is_new] = corners_.try_emplace(key, static_cast<int>(outline_.places.size()));
    if (is_new) outline_.places.push_back(Vec2(cx, cy) * step_);
    return found->second;
  }

  /// Edges that end and begin at a corner of the outline; -1 inside.
  struct Beside {
    int before = -1, after = -1;
  };
  [[nodiscard]] std::vector<Beside> edges_beside() const {
    std::vector<Beside> beside(outline_.places.size());
    for (std::size_t e = 0; e < outline_.edges.size(); ++e) {
      beside[outline_.edges[e].a].after = static_cast<int>(e);
      beside[outline_.edges[e].b].before = static_cast<int>(e);
    }
    return beside;
  }
  [[nodiscard]] Vec2 way(int edge) const {
    const OutlineEdge& e = outline_.edges[edge];
    return outline_.places[e.b] - outline_.places[e.a];
  }

  /// Whether at least kStraight edges on either side of a corner lie on two lines.
  [[nodiscard]] bool is_sharp(const std::vector<Beside>& beside, std::size_t corner) const {
    const Vec2 before = way(beside[corner].before), after = way(beside[corner].after);
    if (before == after) return false;
    int in = beside[corner].before, out = beside[corner].after;
    for (int k = 1; k < kStraight; ++k) {
      in = beside[outline_.edges[in].a].before;
      out = beside[outline_.edges[out].b].after;
      if (way(in) != before || way(out) != after) return false;
    }
    return true;
  }

  void smooth() {
    const std::vector<Beside> beside = edges_beside();
    std::vector<char> moves(outline_.places.size(), 0);
    for (std::size_t c = 0; c < moves.size(); ++c) moves[c] = beside[c].after >= 0 && !is_sharp(beside, c) ? 1 : 0;
    for (int pass = 0; pass < 2 * kPasses; ++pass) {
      const std::vector<Vec2> from = outline_.places;
      for (std::size_t c = 0; c < moves.size(); ++c) {
        if (moves[c] == 0) continue;
        const Vec2 mean = 0.5 * (from[outline_.edges[beside[c].before].a] + from[outline_.edges[beside[c].after].b]);
        outline_.places[c] += (pass % 2 == 0 ? kShrink : kSwell) * (mean - from[c]);
      }
    }
  }

  /// Moves a corner so that the edges before and behind it move outward by their own widening.
  void widen() {
    const std::vector<Beside> beside = edges_beside();
    std::vector<Vec2> moved = outline_.places;
    for (std::size_t c = 0; c < moved.size(); ++c) {
      if (beside[c].after < 0) continue;
      const OutlineEdge &before = outline_.edges[beside[c].before], &after = outline_.edges[beside[c].after];
      if (before.widening == 0.0 && after.widening == 0.0) continue;
      const auto outward = [](const Vec2& way) -> Vec2 { return Vec2(-way.y(), way.x()).normalized(); };
      const Vec2 n = outward(way(beside[c].before)), m = outward(way(beside[c].after));
      const double cosine = n.dot(m), sine2 = 1.0 - cosine * cosine;
      constexpr double kTurn = 0.5;  // Squared sine from which on a corner counts as one: 45 degrees.
      if (cosine >= 0.0 && sine2 < kTurn) {
        moved[c] += 0.5 * (before.widening + after.widening) * (n + m).normalized();
      } else if (sine2 >= kTurn) {
        const double p = (before.widening - cosine * after.widening) / sine2;
        const double q = (after.widening - cosine * before.widening) / sine2;
        moved[c] += p * n + q * m;
      }
    }
    outline_.places = std::move(moved);
  }

  const Squares& squares_;
  int step_;
  FlakeOutline outline_;
  std::map<std::array<int, 3>, int> corners_;
};

}  // namespace

std::vector<FlakeOutline> flake_outlines(const LiftedFlakes& flakes, int step) {
  const Squares squares(flakes, step);
  std::vector<std::vector<Square>> own(flakes.flakes.size());
  for (int y = 0; y < squares.height(); ++y) {
    for (int x = 0; x < squares.width(); ++x) {
      if (const std::int32_t flake = squares.at(x, y); flake >= 0)
        own[static_cast<std::size_t>(flake)].push_back({x, y});
    }
  }
  std::vector<FlakeOutline> outlines;
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (!own[k].empty()) outlines.push_back(Builder(squares, static_cast<std::int32_t>(k), step).build(own[k]));
  }
  return outlines;
}

}  // namespace patinate::simulation
