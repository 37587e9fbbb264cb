/// \file
/// A surface's colour over time, whatever it comes from: a history, or a transfer looked up.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libcommon/history/history.h"

namespace patinate {

/// Frames of a history, or what a transfer's coordinates make of them. Reads `transfer.json` and `coordinates.exr` as files.
/// Thread-safe.
class TextureSeries {
 public:
  /// @param path     A history or a transfer (then over time in its atlas). @param through  A transfer: the history's frames are looked up through
  /// its coordinates; "" = none.
  /// @throws IoError if a file breaks its format; InvalidInput if `through` looks into a history of another size, or is given for a transfer.
  explicit TextureSeries(const std::filesystem::path& path, const std::filesystem::path& through = {});

  /// Of the history: its frames, times and controls.
  [[nodiscard]] const HistoryManifest& manifest() const { return history_.manifest(); }
  [[nodiscard]] const HistoryReader& history() const { return history_; }
  /// "copper", "copper on an atlas".
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// Surface length of a pixel, when known.
  [[nodiscard]] std::optional<double> pixel_mm() const { return pixel_mm_; }
  /// Where the surface's own colour is shown at a time: 0 / 255. Between two frames: where both show it.
  [[nodiscard]] ImageU8 mask(double time) const;
  /// H x W x 3, linear; clamped to the ends.
  [[nodiscard]] ImageF sample(double time) const;
  /// H x W x 1 in [0, 1], normalised as the history's control. @throws InvalidInput if there is no such control.
  [[nodiscard]] ImageF control(const std::string& name) const;
  /// Of everything above.
  [[nodiscard]] std::string key() const;

 private:
  void read_coordinates(const std::filesystem::path& transfer);
  template <class T>
  [[nodiscard]] Image<T> looked_up(Image<T> image) const;

  HistoryReader history_;
  std::string name_;
  std::optional<double> pixel_mm_;
  ImageF coordinates_;  ///< Empty: the history itself.
};

}  // namespace patinate
