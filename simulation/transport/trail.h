/// \file
/// Where gammatons have run last: what they hold when they end is left along that way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "simulation/transport/cargo.h"
#include "simulation/transport/transfer.h"

namespace patinate::simulation {

/// The texels of a gammaton's last contacts since it landed.
class Trail {
 public:
  static constexpr std::size_t kLength = transfer_kernel::kTrailLength;

  /// One more contact; the oldest is forgotten.
  void add(TexelIndex texel) {
    texel_[num_added_ % kLength] = texel;
    num_added_ = transfer_kernel::one_more_added(num_added_);
  }
  void clear() { num_added_ = 0; }
  [[nodiscard]] std::size_t size() const { return transfer_kernel::trail_size(num_added_); }
  /// @param i  [0, size()), the oldest first.
  [[nodiscard]] TexelIndex texel(std::size_t i) const {
    return texel_[transfer_kernel::trail_place(num_added_, static_cast<std::uint32_t>(i))];
  }

 private:
  std::array<TexelIndex, kLength> texel_{};
  std::uint32_t num_added_ = 0;
};

/// Notes contacts; one that comes out of the air begins a new way. @param trails  By gammaton.
void follow(std::span<const Contact> contacts, std::vector<Trail>& trails);

/// A gammaton that ends on the surface.
struct Ending {
  std::uint32_t gammaton = 0;
  Trail trail;  ///< Not empty.
};

}  // namespace patinate::simulation
