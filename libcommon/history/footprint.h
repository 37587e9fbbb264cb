/// \file
/// What a texel shows that covers several pixels of a history: their mean, not one of them.
#pragma once

#include <memory>
#include <string>

#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate {

/// Up to here a texel shows one pixel, as it is: an average would blur more than it smooths.
inline constexpr double kMinFootprint_px = 1.25;
inline constexpr double kLargestFootprint_px = 256.0;

/// Every pixel as the mean of the square of `footprint_px` around it, with a Gaussian of the same variance (pixels are
/// means over themselves already): sigma = sqrt((footprint_px^2 - 1) / 12), which no turn of a patch changes.
/// @param values  H x W x C. @param mask  H x W, what is 0 counts nowhere; may be empty.
/// @param footprint_px  [0, kLargestFootprint_px]; up to kMinFootprint_px `values` come back as they are.
[[nodiscard]] ImageF mean_over_footprint(ImageF values, const ImageU8& mask, double footprint_px);
/// Mean of a map that a frame has beside color, by its name (kFrameExtraNames): pixels of 0 are not known and stay so,
/// normals stay unit.
[[nodiscard]] ImageF mean_extra_over_footprint(const std::string& name, ImageF values, double footprint_px);

/// A history seen through texels that cover several of its pixels: what HistoryReader gives with a footprint, of any
/// history. Controls and geometry stay as they are.
class FootprintHistory final : public History {
 public:
  FootprintHistory(std::shared_ptr<const History> history, double footprint_px);

  [[nodiscard]] const HistoryFacts& facts() const override { return history_->facts(); }
  [[nodiscard]] const std::string& label() const override { return history_->label(); }

 private:
  [[nodiscard]] ImageF load_frame(std::size_t frame) const override;
  [[nodiscard]] ImageF load_frame_extra(std::size_t frame, std::size_t extra) const override;
  [[nodiscard]] ImageF load_control(std::size_t control) const override {
    return history_->read_control(facts().controls[control].name);
  }
  [[nodiscard]] ImageF load_control_deviation(std::size_t control) const override {
    return *history_->read_control_deviation(facts().controls[control].name);
  }
  [[nodiscard]] ImageU8 load_mask() const override { return mask_; }
  [[nodiscard]] ImageF load_map(std::size_t map) const override;
  [[nodiscard]] ImageU8 load_frame_mask(std::size_t frame) const override {
    return history_->read_frame_mask(static_cast<int>(frame));
  }

  std::shared_ptr<const History> history_;
  double footprint_px_;
  ImageU8 mask_;
};

}  // namespace patinate
