#include "simulation/composition/laid_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "libcommon/image/filters.h"

namespace patinate::simulation::composition {

namespace {

double wrapped(double x, int n) { return x - std::floor(x / n) * n; }

/// Checked image of three channels, finite, [0, 1].
ImageF usable(const ImageF& image) {
  ImageF out(image.width(), image.height(), 3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = image.at(x, y, std::min(c, image.channels() - 1));
        out.at(x, y, c) = std::isfinite(value) ? std::clamp(value, 0.0F, 1.0F) : 0.0F;
      }
    }
  }
  return out;
}

}  // namespace

LaidPicture::LaidPicture(const ColorSource& source, double texel_mm)
    : width_mm_(source.image_mm), height_mm_(source.image_mm * source.image.height() / source.image.width()) {
  const auto pixels = [&](double length_mm, int most) {
    return static_cast<int>(std::clamp(std::round(length_mm / texel_mm), 1.0, static_cast<double>(most)));
  };
  image_ = downscale_area(usable(source.image), pixels(width_mm_, source.image.width()),
                          pixels(height_mm_, source.image.height()));
  const std::span<const float> values = image_.values();
  for (std::size_t i = 0; i < values.size(); ++i) mean_[static_cast<int>(i % 3)] += static_cast<double>(values[i]);
  mean_ /= static_cast<double>(values.size() / 3);
}

Vec3 LaidPicture::sample(double x_mm, double y_mm) const {
  const int width = image_.width(), height = image_.height();
  const double x = wrapped(x_mm / width_mm_ * width - 0.5, width);
  const double y = wrapped(y_mm / height_mm_ * height - 0.5, height);
  const int x0 = std::min(static_cast<int>(x), width - 1), y0 = std::min(static_cast<int>(y), height - 1);
  const int x1 = (x0 + 1) % width, y1 = (y0 + 1) % height;
  const double fx = x - x0, fy = y - y0;
  const auto at = [&](int px, int py, int c) { return static_cast<double>(image_.at(px, py, c)); };
  Vec3 color;
  for (int c = 0; c < 3; ++c) {
    color[c] = (1.0 - fy) * ((1.0 - fx) * at(x0, y0, c) + fx * at(x1, y0, c)) +
               fy * ((1.0 - fx) * at(x0, y1, c) + fx * at(x1, y1, c));
  }
  return color;
}

Vec3 LaidPicture::color(const Vec3& point_mm, const Vec3& normal) const {
  std::array<double, 3> weight{};
  double sum = 0.0;
  for (int a = 0; a < 3; ++a) {
    const double square = normal[a] * normal[a];
    weight[a] = square * square;
    sum += square * square;
  }
  if (sum == 0.0) {
    weight.fill(1.0);
    sum = 3.0;
  }
  const Vec3& p = point_mm;
  // Direction as one looks at it: text is not mirrored on the far side. Signs change where a side does not count.
  const auto to_right = [&](int axis) { return normal[axis] < 0.0 ? -1.0 : 1.0; };
  const std::array<std::array<double, 2>, 3> seen{
      {{-to_right(0) * p.z(), -p.y()}, {to_right(1) * p.x(), p.z()}, {to_right(2) * p.x(), -p.y()}}};
  Vec3 deviation = Vec3::Zero();
  double squares = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    const double share = weight[a] / sum;
    if (share < 1e-3) continue;
    const Vec3 side = sample(seen[a][0], seen[a][1]);
    for (int c = 0; c < 3; ++c) deviation[c] += share * (side[c] - mean_[c]);
    squares += share * share;
  }
  const double contrast = 1.0 / std::sqrt(squares);
  Vec3 color;
  for (int c = 0; c < 3; ++c) color[c] = std::clamp(mean_[c] + contrast * deviation[c], 0.0, 1.0);
  return color;
}

void MaterialPictures::set(std::span<const MaterialAppearance> looks) {
  fields_.resize(looks.size());
  const SurfaceAtlas& surface = places_->surface();
  for (std::size_t m = 0; m < looks.size(); ++m) {
    const ColorSource& source = looks[m].color;
    Field& field = fields_[m];
    if (field.image == source.image && field.image_mm == source.image_mm) continue;
    field = Field{.image = source.image, .image_mm = source.image_mm};
    if (source.image.empty()) continue;
    if (source.image_mm > 0.0) {
      field.in_mm.emplace(source, surface.median_texel_size_mm());
      field.codes = TileCache(surface.grid().num_tiles(), 3 * kTile);
    } else {
      field.by_texel = make_picture(source.image);
    }
  }
}

void MaterialPictures::read_tile(std::size_t material, TileIndex tile, std::uint16_t* out) {
  Field& field = fields_[material];
  const TexelIndex first = tile * kTile;
  if (!field.in_mm) {
    const TileGrid& grid = places_->surface().grid();
    field.by_texel.read_tile(grid.x(first), grid.y(first), out);
    return;
  }
  const std::uint8_t* codes = field.codes.tile(tile, [&](std::span<std::uint8_t> bytes) {
    for (TexelIndex l = 0; l < kTile; ++l) {
      const std::array<std::uint8_t, 3> code =
          srgb8_of(field.in_mm->color(places_->point(first + l), places_->normal(first + l)));
      for (std::size_t c = 0; c < 3; ++c) bytes[c * kTile + l] = code[c];
    }
  });
  for (std::size_t i = 0; i < 3 * kTile; ++i) out[i] = linear16_of_srgb8()[codes[i]];
}

std::size_t MaterialPictures::memory() const {
  std::size_t bytes = 0;
  for (const Field& field : fields_) {
    bytes += field.image.values().size() * sizeof(float) + field.by_texel.planes.size() * sizeof(std::uint16_t) +
             field.codes.memory();
  }
  return bytes;
}

}  // namespace patinate::simulation::composition
