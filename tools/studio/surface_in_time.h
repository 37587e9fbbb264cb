/// \file
/// A history, transfer or simulation, opened: its color at any time, its maps, its curves. What is slow to read is
/// kept.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libcommon/image/between_pixels.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/image.h"
#include "patinate/transfer/transfer_reader.h"
#include "tools/studio/place.h"

namespace patinate::studio {

/// Values of a map and what it is called.
struct NamedMap {
  ImageF values;     ///< H x W x C, over the place's texture.
  double low = 0.0;  ///< Values that 0 and 1 of a control stand for; else [0, 1].
  double high = 1.0;
  std::string unit;
};

/// Maps of a surface at a time: its color; or of its material base color, glTF's occlusion, roughness and metalness,
/// or the reflectance of what is no metal.
enum class SurfaceMap { Color, Base, Orm, Reflectance };
inline constexpr std::array<std::string_view, 4> kSurfaceMapNames{"color", "base", "orm", "reflectance"};

/// Of Between, as requests name them.
inline constexpr std::array<std::string_view, 3> kBetweenNames{"blend", "hold", "nearest"};

/// A number of one texel, constant in time.
struct TexelValue {
  std::string name, unit;
  double value = 0.0;
};

/// A number of one texel at the time of every frame; nothing where a frame does not know it.
struct ValueCurve {
  std::string name, unit;
  std::vector<std::optional<double>> values;
};

/// Color of one texel over time, and all other numbers that are known of it.
struct TexelCurve {
  std::vector<double> times;
  std::vector<std::array<int, 3>> srgb;
  std::vector<std::array<double, 3>> lab;
  std::vector<ValueCurve> values;            ///< Amounts, height, metalness.
  std::vector<TexelValue> constants;         ///< Controls and maps, in their units.
  std::optional<std::array<int, 2>> source;  ///< For a transfer: the pixel of its history.
};

/// Thread-safe.
class SurfaceInTime {
 public:
  /// @param path  A history, transfer or simulation folder. @throws IoError
  SurfaceInTime(const std::filesystem::path& path, PlaceKind kind);

  [[nodiscard]] PlaceKind kind() const { return kind_; }
  [[nodiscard]] const HistoryReader& history() const { return *history_; }
  /// nullptr unless it is a transfer.
  [[nodiscard]] const transfer::TransferReader* transfer() const { return transfer_.get(); }
  [[nodiscard]] int width() const;  ///< Width of its texture: of a transfer, the sheet of all tiles.
  [[nodiscard]] int height() const;

  /// Those that it knows beyond its color, in their order. Base color is one of them where it differs from color.
  [[nodiscard]] std::vector<SurfaceMap> material() const;
  /// One of its maps as `lookup` writes it (of a history, as its frames are): H x W x 3, linear.
  /// @param tile  Of a transfer with several; nothing: the whole sheet. @throws InvalidInput if there is no such tile;
  /// or it knows nothing of the map; Canceled.
  [[nodiscard]] ImageF texture(SurfaceMap map, double time, Between between, std::optional<int> tile,
                               const RunControl& control) const;
  /// What its frames hold beside color, by names of kMaterialMapNames: maps `frame:NAME`.
  [[nodiscard]] std::vector<std::string> frame_maps() const;
  /// Materials whose amounts its frames hold: maps `amount:NAME`.
  [[nodiscard]] std::vector<std::string> amounts() const;
  /// control:NAME, map:NAME, frame:NAME and amount:NAME at a time, mask:FRAME, coordinates (transfers), coverage.
  /// @throws InvalidInput listing what there is.
  [[nodiscard]] NamedMap map(const std::string& name, double time) const;
  /// @throws InvalidInput if the texel lies outside.
  [[nodiscard]] TexelCurve curve(int x, int y, const RunControl& control) const;
  /// UVs over texture(). @throws InvalidInput for a history, which has none.
  [[nodiscard]] Mesh mesh() const;
  [[nodiscard]] std::size_t memory() const;

 private:
  /// An image, read unless it was of late.
  [[nodiscard]] std::shared_ptr<const ImageF> kept(const std::string& name, const std::function<ImageF()>& read) const;
  [[nodiscard]] std::shared_ptr<const ImageF> frame(int index) const;
  [[nodiscard]] ImageF history_sample(double time, Between between) const;
  [[nodiscard]] ImageF material_sample(SurfaceMap map, double time, Between between) const;
  /// A history's image as it lies on the surface, gutters filled.
  [[nodiscard]] ImageF spread(const ImageF& source, const RunControl& control) const;
  [[nodiscard]] std::array<float, 2> source_of(int x, int y) const;
  [[nodiscard]] ImageF amounts_of_frame(int index, const std::vector<std::string>& materials) const;
  [[nodiscard]] ImageF amount_at(const std::string& material, double time) const;
  void add_values(const NearestPixel& at, TexelCurve& curve, const RunControl& control) const;

  std::filesystem::path path_;
  PlaceKind kind_;
  std::shared_ptr<const transfer::TransferReader> transfer_;
  std::shared_ptr<const HistoryReader> history_;
  ImageF filled_coordinates_;  ///< Coordinates of a transfer: every texel has a source, gutters that of the nearest
                               ///< inside.

  mutable std::mutex mutex_;
  mutable std::list<std::pair<std::string, std::shared_ptr<const ImageF>>> images_;  ///< Last used first.
};

/// Opened places, the last few of them. Thread-safe; who holds one keeps it.
class OpenedPlaces {
 public:
  /// @throws IoError, InvalidInput if it is of another kind. A place that has changed on disk since is opened again.
  [[nodiscard]] std::shared_ptr<const SurfaceInTime> open(const std::filesystem::path& path, PlaceKind kind);

 private:
  struct Entry {
    std::filesystem::path path;
    std::filesystem::file_time_type changed;
    std::shared_ptr<const SurfaceInTime> place;
  };
  std::mutex mutex_;
  std::list<Entry> entries_;  ///< Last used first.
};

}  // namespace patinate::studio
