/// \file
/// Where gammatons have run last: what they hold when they end is left along that way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "simulation/transport/cargo.h"

namespace patinate::simulation {

/// The texels of a gammaton's last contacts since it landed.
class Trail {
 public:
  static constexpr std::size_t kLength = 16;

  /// One more contact; the oldest is forgotten.
  void add(TexelIndex texel) {
    texel_[num_added_ % kLength] = texel;
    // Stays below 2 * kLength, and keeps its place in the ring.
    num_added_ = num_added_ + 1 == 2 * kLength ? kLength : num_added_ + 1;
  }
  void clear() { num_added_ = 0; }
  [[nodiscard]] std::size_t size() const { return num_added_ < kLength ? num_added_ : kLength; }
  /// @param i  [0, size()), the oldest first.
  [[nodiscard]] TexelIndex texel(std::size_t i) const { return texel_[(num_added_ - size() + i) % kLength]; }

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
