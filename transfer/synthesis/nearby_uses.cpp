#include "transfer/synthesis/nearby_uses.h"

#include <algorithm>

#include "libcommon/core/parallel.h"

namespace patinate::transfer {

namespace {

constexpr std::size_t kMaxCounts = std::size_t{1} << 24;  // 32 MB: of larger atlases, squares are larger.

}  // namespace

NearbyUses::NearbyUses(const SourceLevel& source, const TexelMap& map)
    : source_width_(source.width()),
      columns_((source.width() + kCell_px - 1) / kCell_px),
      num_cells_(static_cast<std::size_t>(columns_) *
                 static_cast<std::size_t>((source.height() + kCell_px - 1) / kCell_px)),
      usable_in_(num_cells_, 0),
      num_usable_(static_cast<std::int64_t>(source.usable.size())),
      width_(map.width()),
      height_(map.height()) {
  for (std::int32_t p : source.usable) ++usable_in_[cell_of(p)];
  do {
    squares_x_ = (width_ + side_ - 1) / side_;
    squares_y_ = (height_ + side_ - 1) / side_;
    side_ *= 2;
  } while (squares_x_ * squares_y_ > 1 && static_cast<std::size_t>(squares_x_ * squares_y_) * num_cells_ > kMaxCounts);
  side_ /= 2;
}

void NearbyUses::measure(const PlaceMap& places, const RunControl& control) {
  const auto num_squares = static_cast<std::size_t>(squares_x_ * squares_y_);
  copies_.resize(num_squares * num_cells_);
  std::vector<std::uint16_t> uses(num_squares * num_cells_, 0);
  std::vector<std::int64_t> texels_in(num_squares, 0);
  // A thread counts whole rows of squares: no two write to one count.
  parallel_for(squares_y_, 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (TexelId t = begin * side_ * width_; t < std::min(end * side_, height_) * width_; ++t) {
      const std::int32_t pixel = places.pixels[t];
      if (pixel < 0) continue;
      const std::size_t square = square_of(t);
      ++texels_in[square];
      std::uint16_t& n = uses[square * num_cells_ + cell_of(pixel)];
      n = static_cast<std::uint16_t>(std::min(n + 1, 0xFFFF));
    }
  });
  parallel_for(squares_y_ * squares_x_, 1, control, [&](std::int64_t begin, std::int64_t) {
    const std::int64_t x = begin % squares_x_, y = begin / squares_x_;
    std::vector<std::int64_t> sum(num_cells_, 0);
    std::int64_t num_texels = 0;
    for (std::int64_t v = std::max<std::int64_t>(0, y - 1); v <= std::min(squares_y_ - 1, y + 1); ++v) {
      for (std::int64_t u = std::max<std::int64_t>(0, x - 1); u <= std::min(squares_x_ - 1, x + 1); ++u) {
        const auto square = static_cast<std::size_t>(v * squares_x_ + u);
        num_texels += texels_in[square];
        for (std::size_t c = 0; c < num_cells_; ++c) sum[c] += uses[square * num_cells_ + c];
      }
    }
    for (std::size_t c = 0; c < num_cells_; ++c) {
      const std::int64_t copy = std::max<std::int64_t>({1, usable_in_[c], num_texels * usable_in_[c] / num_usable_});
      copies_[static_cast<std::size_t>(begin) * num_cells_ + c] =
          static_cast<std::uint16_t>(std::min<std::int64_t>(sum[c] * kOneCopy / copy, kMaxCopies));
    }
  });
}

}  // namespace patinate::transfer
