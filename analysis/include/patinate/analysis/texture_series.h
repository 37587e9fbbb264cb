/// A surface's color over time, read from a history or looked up from a transfer.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "patinate/history/history.h"

namespace patinate::analysis {

/// An atlas on which a history is looked up.
struct SeriesAtlas {
  std::string name;                ///< "bust.obj"
  ImageF coordinates;              ///< H x W x 2: places in the history in pixels, -1 outside.
  std::optional<double> texel_mm;  ///< Surface length of a pixel of the history, when known.
};

/// Frames of a history, or what an atlas makes of them. Thread-safe.
class TextureSeries {
 public:
  explicit TextureSeries(std::shared_ptr<const History> history);
  /// @throws InvalidInput naming a coordinate that points outside of the history.
  TextureSeries(std::shared_ptr<const History> history, SeriesAtlas atlas);

  /// Frames, times and controls of the history.
  [[nodiscard]] const HistoryFacts& facts() const { return history_->facts(); }
  [[nodiscard]] const History& history() const { return *history_; }
  /// Empty: the history itself.
  [[nodiscard]] const ImageF& coordinates() const { return coordinates_; }
  /// "copper", "copper on an atlas".
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// Surface length of a pixel, when known.
  [[nodiscard]] std::optional<double> pixel_mm() const { return pixel_mm_; }
  /// Mask (0 / 255) of the places that show the surface's own color at a time. Between two frames, both must show it.
  [[nodiscard]] ImageU8 mask(double time) const;
  /// H x W x 3, linear; clamped to the ends.
  [[nodiscard]] ImageF sample(double time) const;
  /// Every frame says how certain its color is.
  [[nodiscard]] bool has_deviation() const;
  /// Standard deviation of sample(): H x W x 3, linear; 0 where not known. @throws InvalidInput unless has_deviation().
  [[nodiscard]] ImageF deviation(double time) const;
  /// A map of the history where its places are on this surface. @param image  Of the history's size; 1 to 4 channels.
  [[nodiscard]] ImageF on_surface(ImageF image) const { return looked_up(std::move(image)); }
  /// H x W x 1 in [0, 1], normalized as the history's control. @throws InvalidInput if there is no such control.
  [[nodiscard]] ImageF control(const std::string& name) const;

 private:
  [[nodiscard]] ImageU8 looked_up(ImageU8 codes) const;  ///< Of the nearest pixel.
  [[nodiscard]] ImageF looked_up(ImageF values) const;

  std::shared_ptr<const History> history_;
  std::string name_;
  std::optional<double> pixel_mm_;
  ImageF coordinates_;
};

/// A series of files.
struct SeriesFile {
  std::shared_ptr<const HistoryReader> history;
  TextureSeries series;

  /// Content key of all of it.
  [[nodiscard]] std::string key() const;
};
/// Reads `transfer.json` and `coordinates.exr` as files.
/// @param path     A history or a transfer (then over time in its atlas). @param through  A transfer: the history's
/// frames are looked up through its coordinates; "" = none.
/// @throws IoError if a file breaks its format; InvalidInput if `through` looks into a history of another size, or is
/// given for a transfer.
[[nodiscard]] SeriesFile open_series(const std::filesystem::path& path, const std::filesystem::path& through = {});

}  // namespace patinate::analysis
