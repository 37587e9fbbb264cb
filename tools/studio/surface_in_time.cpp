#include "tools/studio/surface_in_time.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "libcommon/image/between_pixels.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/atlas/dilate.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxImageBytes = std::size_t{256} << 20;  ///< Of decoded images that a place keeps.
constexpr std::size_t kMaxPlaces = 4;

std::size_t bytes_of(const ImageF& image) { return image.values().size() * sizeof(float); }

ImageF filled_coordinates(const transfer::TransferReader& transfer) {
  const Sheet& sheet = transfer.sheet();
  const ImageU8 coverage = transfer.coverage();
  ImageF filled = transfer.coordinates();
  for (int i = 0; i < sheet.num_tiles(); ++i) {
    ImageF tile = cut_tile(filled, sheet, i);
    dilate(tile, cut_tile(coverage, sheet, i), -1);
    paste_tile(filled, sheet, i, tile);
  }
  return filled;
}

fs::path manifest_of(const fs::path& path, PlaceKind kind) {
  switch (kind) {
    case PlaceKind::Transfer:
      return path / "transfer.json";
    case PlaceKind::Simulation:
      return path / "simulation.json";
    default:
      return path / kHistoryManifestFile;
  }
}

}  // namespace

SurfaceInTime::SurfaceInTime(const fs::path& path, PlaceKind kind) : path_(path), kind_(kind) {
  switch (kind) {
    case PlaceKind::History:
      history_ = std::make_shared<const HistoryReader>(path);
      break;
    case PlaceKind::Simulation:
      history_ = std::make_shared<const HistoryReader>(path / "history");
      break;
    case PlaceKind::Transfer:
      transfer_ = std::make_shared<const transfer::TransferReader>(path);
      history_ = std::shared_ptr<const HistoryReader>(transfer_, &transfer_->history());
      filled_coordinates_ = filled_coordinates(*transfer_);
      break;
    default:
      throw InvalidInput(path.string() + ": is no history, transfer or simulation, and has no color over time");
  }
}

int SurfaceInTime::width() const { return transfer_ ? transfer_->sheet().width() : history_->manifest().width; }
int SurfaceInTime::height() const { return transfer_ ? transfer_->sheet().height() : history_->manifest().height; }

std::shared_ptr<const ImageF> SurfaceInTime::kept(const std::string& name, const std::function<ImageF()>& read) const {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(images_.begin(), images_.end(), [&](const auto& i) { return i.first == name; });
    if (found != images_.end()) {
      images_.splice(images_.begin(), images_, found);
      return images_.front().second;
    }
  }
  auto image = std::make_shared<const ImageF>(read());
  const std::lock_guard lock(mutex_);
  std::size_t sum = bytes_of(*image);
  for (auto it = images_.begin(); it != images_.end();) {
    sum += bytes_of(*it->second);
    it = sum > kMaxImageBytes || it->first == name ? images_.erase(it) : std::next(it);
  }
  images_.emplace_front(name, image);
  return image;
}

std::shared_ptr<const ImageF> SurfaceInTime::frame(int index) const {
  return kept("color " + std::to_string(index), [&] { return history_->read_frame(index); });
}

/// As sample() of history_sampling.h, to the bit.
ImageF SurfaceInTime::history_sample(double time, Between between) const {
  const TimePosition position = locate(*history_, time, between);
  const std::shared_ptr<const ImageF> first = frame(position.index);
  if (position.fraction == 0.0) return *first;
  const std::shared_ptr<const ImageF> next = frame(position.index + 1);
  const float fraction = static_cast<float>(position.fraction);
  ImageF image = *first;
  const auto to = image.values();
  const auto from = next->values();
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = (1.0f - fraction) * to[i] + fraction * from[i];
  return image;
}

ImageF SurfaceInTime::spread(const ImageF& source, const RunControl& control) const {
  return transfer_ ? transfer::gather(source, filled_coordinates_, 0.0f, control) : source;
}

std::vector<SurfaceMap> SurfaceInTime::material() const {
  const std::vector<MaterialMap> known = material_maps(history_->facts());
  const auto knows = [&](MaterialMap map) { return std::find(known.begin(), known.end(), map) != known.end(); };
  std::vector<SurfaceMap> maps;
  if (knows(MaterialMap::Tint) && knows(MaterialMap::Metalness)) maps.push_back(SurfaceMap::Base);
  if (knows(MaterialMap::Roughness) || knows(MaterialMap::Metalness)) maps.push_back(SurfaceMap::Orm);
  if (knows(MaterialMap::Specular)) maps.push_back(SurfaceMap::Reflectance);
  return maps;
}

ImageF SurfaceInTime::material_sample(SurfaceMap map, double time, Between between) const {
  if (map == SurfaceMap::Base) return sample_base_color(*history_, time, between);
  if (map == SurfaceMap::Orm) return sample_orm(*history_, time, between);
  ImageF reflectance = sample_reflectance(*history_, time, between);
  if (reflectance.empty()) throw InvalidInput(path_.string() + ": knows nothing of its reflectance");
  return reflectance;
}

ImageF SurfaceInTime::texture(SurfaceMap map, double time, Between between, std::optional<int> tile,
                              const RunControl& control) const {
  const int num_tiles = transfer_ ? transfer_->sheet().num_tiles() : 1;
  if (tile && (*tile < 0 || *tile >= num_tiles))
    throw InvalidInput("there is no tile " + std::to_string(*tile) + "; there are " + std::to_string(num_tiles) +
                       ", counted from 0");
  ImageF image =
      spread(map == SurfaceMap::Color ? history_sample(time, between) : material_sample(map, time, between), control);
  control.throw_if_stopped();
  return tile && transfer_ ? cut_tile(image, transfer_->sheet(), *tile) : image;
}

/// -1, -1 outside the charts.
std::array<float, 2> SurfaceInTime::source_of(int x, int y) const {
  if (!transfer_) return {static_cast<float>(x), static_cast<float>(y)};
  const ImageF& c = transfer_->coordinates();
  return {c.at(x, y, 0), c.at(x, y, 1)};
}

TexelCurve SurfaceInTime::curve(int x, int y, const RunControl& control) const {
  if (x < 0 || y < 0 || x >= width() || y >= height()) {
    throw InvalidInput("texel " + std::to_string(x) + ", " + std::to_string(y) + " lies outside " +
                       size_text(width(), height()));
  }
  TexelCurve curve;
  const auto [source_x, source_y] = source_of(x, y);
  const bool is_outside = source_x < 0.0f;  // Texels outside the charts have no color of their own.
  const NearestPixel nearest = is_outside ? NearestPixel{-1, -1, {}} : nearest_pixel(source_x, source_y);
  if (transfer_) curve.source = {nearest.x, nearest.y};
  if (is_outside) return curve;
  for (int f = 0; f < history_->num_frames(); ++f) {
    control.throw_if_stopped();
    const std::shared_ptr<const ImageF> image = frame(f);
    std::array<float, 3> rgb{};
    look_at<3>(image->data(), image->width(), image->height(), source_x, source_y, rgb.data());
    curve.times.push_back(history_->manifest().frames[f].time);
    curve.srgb.push_back({srgb8_from_linear(rgb[0]), srgb8_from_linear(rgb[1]), srgb8_from_linear(rgb[2])});
    curve.lab.push_back(
        lab_from_linear(static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2])));
  }
  add_values(nearest, curve, control);
  return curve;
}

Mesh SurfaceInTime::mesh() const {
  if (kind_ == PlaceKind::History) throw InvalidInput("a history has no mesh: it is a flat picture over time");
  if (transfer_) return transfer_->mesh();
  Mesh mesh = with_normals(read_mesh(path_ / "model.glb"));
  scale_mesh(mesh, 1000.0);  // glTF is in m
  return mesh;
}

std::size_t SurfaceInTime::memory() const {
  const std::lock_guard lock(mutex_);
  std::size_t sum = 2 * bytes_of(filled_coordinates_);
  for (const auto& [name, image] : images_) sum += bytes_of(*image);
  return sum;
}

std::shared_ptr<const SurfaceInTime> OpenedPlaces::open(const fs::path& path, PlaceKind kind) {
  std::error_code error;
  const fs::file_time_type changed = fs::last_write_time(manifest_of(path, kind), error);
  const auto find = [&] {
    return std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.path == path; });
  };
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = find(); found != entries_.end() && found->changed == changed) {
      entries_.splice(entries_.begin(), entries_, found);
      return entries_.front().place;
    }
  }
  auto place = std::make_shared<const SurfaceInTime>(path, kind);  // unlocked: others continue meanwhile
  const std::lock_guard lock(mutex_);
  if (const auto found = find(); found != entries_.end()) entries_.erase(found);
  entries_.push_front({path, changed, place});
  if (entries_.size() > kMaxPlaces) entries_.pop_back();
  return place;
}

}  // namespace patinate::studio
