#include "simulation/composition/grain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <new>

#include "patinate/controls/noise.h"

namespace patinate::simulation::composition {

namespace {

constexpr int kOctaves = 3;
constexpr double kFine = 8.0;         ///< The coarse half's length over the fine half's.
constexpr double kLeastTexels = 2.0;  ///< What is shorter cannot be shown.

}  // namespace

void Grain::Free::operator()(std::uint8_t* values) const { std::free(values); }

Grain::Grain(const SceneMesh& scene_mesh, const SurfaceAtlas& surface) : surface_(&surface) {
  const Mesh& mesh = scene_mesh.mesh;
  const double side = surface.grid().width;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Matrix<double, 3, 2> step = surface.mm_per_texel(static_cast<int>(t)).cast<double>();
    const Vec2& uv = mesh.uvs[static_cast<std::size_t>(mesh.uv_triangles[t][0])];
    const Vec2 texel(uv.x() * side - 0.5, (1.0 - uv.y()) * side - 0.5);
    const Vec3& corner = mesh.positions[static_cast<std::size_t>(mesh.triangles[t][0])];
    Place place;
    place.step = step;
    for (int i = 0; i < 3; ++i) place.origin[i] = corner[i] - (step(i, 0) * texel.x() + step(i, 1) * texel.y());
    places_.push_back(place);
  }
}

void Grain::set_lengths(const std::vector<double>& lengths_mm) {
  fields_.resize(lengths_mm.size());
  for (std::size_t m = 0; m < lengths_mm.size(); ++m) {
    Field& field = fields_[m];
    if (field.length == lengths_mm[m]) continue;
    field = Field{.length = lengths_mm[m]};
    if (!(field.length > 0.0)) continue;
    field.values.reset(static_cast<std::uint8_t*>(std::calloc(surface_->grid().num_texels(), 1)));
    if (!field.values) throw std::bad_alloc();
    field.is_made.resize(surface_->grid().num_tiles());
  }
}

double Grain::value(std::size_t material, TexelIndex t) const {
  double value = 0.5;
  values(material, std::span(&t, 1), std::span(&value, 1));
  return value;
}

void Grain::values(std::size_t material, std::span<const TexelIndex> texels, std::span<double> out) const {
  std::array<Vec3, kTile> at;
  std::array<double, kTile> coarse, fine;
  for (std::size_t n = 0; n < texels.size(); ++n) {
    const int triangle = surface_->triangle(texels[n]);
    at[n] = Vec3::Zero();
    if (triangle < 0) continue;
    const Place& place = places_[static_cast<std::size_t>(triangle)];
    const double x = surface_->grid().x(texels[n]), y = surface_->grid().y(texels[n]);
    for (int i = 0; i < 3; ++i) at[n][i] = place.origin[i] + (place.step(i, 0) * x + place.step(i, 1) * y);
  }
  const double length = fields_[material].length, least = kLeastTexels * surface_->median_texel_size_mm();
  const auto seed = static_cast<std::int64_t>(2 * material + 1);
  const std::span<const Vec3> places = std::span(at).first(texels.size());
  noise_at(places, {.wavelength_mm = length, .octaves = kOctaves, .seed = seed}, least, coarse);
  noise_at(places, {.wavelength_mm = length / kFine, .octaves = kOctaves, .seed = seed + 1}, least, fine);
  constexpr double kHalf = 0.70710678118654752;  // Two of them are as strong as one.
  for (std::size_t n = 0; n < texels.size(); ++n) {
    out[n] = surface_->is_covered(texels[n]) ? std::clamp(0.5 + kHalf * ((coarse[n] - 0.5) + (fine[n] - 0.5)), 0.0, 1.0)
                                             : 0.5;
  }
}

const std::uint8_t* Grain::tile(std::size_t material, TileIndex tile) {
  Field& field = fields_[material];
  std::uint8_t* const bytes = field.values.get() + std::size_t{tile} * kTile;
  if (field.is_made[tile] == 0) {
    std::array<TexelIndex, kTile> texels;
    std::array<double, kTile> noise;
    for (std::uint32_t l = 0; l < kTile; ++l) texels[l] = tile * kTile + l;
    values(material, texels, noise);
    for (std::size_t l = 0; l < kTile; ++l) bytes[l] = static_cast<std::uint8_t>(255.0 * noise[l] + 0.5);
    field.is_made[tile] = 1;
  }
  return bytes;
}

std::size_t Grain::memory() const {
  std::size_t bytes = places_.capacity() * sizeof(Place);
  for (const Field& field : fields_) {
    bytes += field.is_made.size() +
             kTile * static_cast<std::size_t>(std::count(field.is_made.begin(), field.is_made.end(), std::uint8_t{1}));
  }
  return bytes;
}

}  // namespace patinate::simulation::composition
