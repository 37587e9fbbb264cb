#include "analysis/evaluation/synthesized_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::int64_t kChunk = 16384;

using Pairs = std::vector<TexelPair>;

/// The offset of one texel step in a triangle's frame.
Vec2 step_mm(const TexelMap& surface, const FlowFrames& frames, TexelId t, int dx, int dy) {
  const int triangle = surface.triangle(t);
  return frames[triangle].transpose() * (surface.mm_per_texel(triangle) * Vec2(dx, dy));
}

/// The texel one step away in the atlas, in the same chart; -1 if there is none.
TexelId beside(const TexelMap& surface, TexelId t, int dx, int dy) {
  const auto x = static_cast<int>(t % surface.width()) + dx, y = static_cast<int>(t / surface.width()) + dy;
  if (x < 0 || y < 0 || x >= surface.width() || y >= surface.height()) return -1;
  const TexelId n = TexelId{y} * surface.width() + x;
  return surface.is_covered(n) && surface.chart(n) == surface.chart(t) ? n : -1;
}

}  // namespace

std::shared_ptr<const TexelMap> flat_surface(int width, int height, double texel_mm) {
  const double w = width * texel_mm, h = height * texel_mm;
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {w, 0, 0}, {w, h, 0}, {0, h, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.normals = {{0, 0, 1}};
  for (const auto& c : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
    mesh.triangles.push_back(c);
    mesh.uv_triangles.push_back(c);
    mesh.normal_triangles.push_back({0, 0, 0});
  }
  return std::make_shared<TexelMap>(std::move(mesh), width, height);
}

CoordinateReader reader_of(const ImageF& coordinates) {
  return [&coordinates](const TexelRect& rect, const CoordinateVisitor& visit) {
    for (int y = rect.y0; y < rect.y1; ++y)
      visit(y, coordinates.row(y).subspan(2 * static_cast<std::size_t>(rect.x0),
                                          2 * static_cast<std::size_t>(rect.width())));
  };
}

void SourceIndices::set(const TexelMap& surface, TexelId t, const float* xy) {
  const double x = std::floor(static_cast<double>(xy[0]) + 0.5), y = std::floor(static_cast<double>(xy[1]) + 0.5);
  if (!(x >= 0.0 && y >= 0.0 && x < width_ && y < height_)) {
    throw InvalidInput(name_ + ": texel " + std::to_string(t % surface.width()) + ", " +
                       std::to_string(t / surface.width()) + " comes from " + number_text(x) + ", " + number_text(y) +
                       ", which is not in the source of " + size_text(width_, height_));
  }
  index_[t] = static_cast<std::int32_t>(y) * width_ + static_cast<std::int32_t>(x) + 1;
  const BesidePixel beside = nearest_pixel(xy[0], xy[1]).beside;
  beside_[2 * static_cast<std::size_t>(t)] = beside.x;
  beside_[2 * static_cast<std::size_t>(t) + 1] = beside.y;
}

void SourceIndices::read(const TexelMap& surface, const TexelRect& rect, const CoordinateReader& reader) {
  reader(rect, [&](int y, std::span<const float> row) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const TexelId t = TexelId{y} * surface.width() + x;
      if (surface.is_covered(t)) set(surface, t, &row[2 * static_cast<std::size_t>(x - rect.x0)]);
    }
  });
}

void SourceIndices::read(const TexelMap& surface, std::vector<TexelId> texels, const CoordinateReader& reader) {
  const Sheet& sheet = surface.sheet();
  std::sort(texels.begin(), texels.end());
  for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
    const TexelRect cell = cell_of(sheet, tile);
    const auto is_here = [&](TexelId t) {
      return cell.contains(static_cast<int>(t % surface.width()), static_cast<int>(t / surface.width()));
    };
    std::vector<TexelId> here;
    std::copy_if(texels.begin(), texels.end(), std::back_inserter(here), is_here);
    if (here.empty()) continue;
    const auto row_of = [&](TexelId t) { return static_cast<int>(t / surface.width()); };
    auto next = here.begin();
    reader({cell.x0, row_of(here.front()), cell.x1, row_of(here.back()) + 1}, [&](int y, std::span<const float> row) {
      for (; next != here.end() && row_of(*next) == y; ++next)
        set(surface, *next, &row[2 * static_cast<std::size_t>(*next % surface.width() - cell.x0)]);
    });
  }
}

ImageU8 MapPart::coverage() const {
  ImageU8 out(rect.width(), rect.height());
  for_each_covered([&](TexelId, std::int64_t i) { out.data()[i] = 255; });
  return out;
}

ImageF MapPart::gathered(const ImageF& source) const {
  ImageF out(rect.width(), rect.height(), source.channels());
  const auto channels = static_cast<std::int64_t>(source.channels());
  for_each_covered([&](TexelId t, std::int64_t i) {
    std::copy_n(source.data() + indices.of(t) * channels, channels, out.data() + i * channels);
  });
  return out;
}

ImageF MapPart::looked_up(const ImageF& source) const {
  ImageF out(rect.width(), rect.height());
  for_each_covered([&](TexelId t, std::int64_t i) {
    look_between<1>(source.data(), source.width(), source.height(), indices.x(t), indices.y(t), indices.beside(t),
                    out.data() + i);
  });
  return out;
}

Vec2 SourceAxes::along_source(TexelId t, const Vec2& step_mm) const {
  if (turns.empty() || turns[t] == 0) return step_mm;
  constexpr double kTurn = 2.0 * std::numbers::pi / 65536.0;
  return Eigen::Rotation2Dd(kTurn * turns[t]) * step_mm;
}

std::optional<TexelPair> interior_pair(const TexelMap& surface, const SourceAxes& axes, TexelId t, int dx, int dy) {
  const TexelId n = beside(surface, t, dx, dy);
  if (n < 0) return std::nullopt;
  return TexelPair{t, n, axes.along_source(t, step_mm(surface, axes.frames, t, dx, dy))};
}

Pairs seam_pairs(const TexelMap& surface, const SourceAxes& axes, const TexelRect& rect, const RunControl& control) {
  const auto add = [&](TexelId t, Pairs& out) {
    for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
      if (beside(surface, t, dx, dy) >= 0) continue;
      const std::array<Vec2, 1> offset{step_mm(surface, axes.frames, t, dx, dy)};
      std::array<TexelNeighbor, 1> n;
      surface.gather(t, axes.frames, offset, n);
      if (n[0].texel < 0 || n[0].texel == t) continue;
      if (n[0].offset_mm.squaredNorm() > 0.0) out.push_back({t, n[0].texel, axes.along_source(t, n[0].offset_mm)});
    }
  };
  return parallel_reduce(
      rect.num_texels(), kChunk, control, Pairs{},
      [&](std::int64_t begin, std::int64_t end) {
        Pairs part;
        for (std::int64_t i = begin; i < end; ++i) {
          const TexelId t = (rect.y0 + i / rect.width()) * surface.width() + rect.x0 + i % rect.width();
          if (surface.is_covered(t)) add(t, part);
        }
        return part;
      },
      [](Pairs a, const Pairs& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
}

}  // namespace patinate::analysis
