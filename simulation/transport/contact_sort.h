/// \file
/// Contacts in the order of their texels: a radix sort that also cuts them into sections that can be worked on at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"

namespace patinate::simulation {

/// texel << 32 | carrier: sorted by texel, those of one texel in the order of their carriers.
using ContactKey = std::uint64_t;

/// Sorts keys, keeping its memory from call to call.
class ContactSort {
 public:
  /// What one section needs besides the keys; one for each thread.
  using Scratch = std::vector<ContactKey>;

  /// Cuts `keys` into sections by texel: none shares an 8 x 8 tile with another, and each has only texels beyond those
  /// before it. Sections depend on the keys alone. Few keys (up to 32768) are sorted at once; of more, each section has
  /// to be by sort_section().
  /// @param keys       In the order of their carriers.
  /// @param num_texels  All texels are below; <= 2^30.
  void cut(std::span<ContactKey> keys, std::uint32_t num_texels, const RunControl& control = {});

  [[nodiscard]] std::int64_t num_sections() const { return static_cast<std::int64_t>(ends_.size()) - 1; }
  /// Where a section begins among all keys.
  [[nodiscard]] std::size_t begin_of(std::int64_t section) const { return ends_[static_cast<std::size_t>(section)]; }
  /// The keys of a section, sorted. Different sections may be sorted by several threads at once.
  [[nodiscard]] std::span<const ContactKey> sort_section(std::int64_t section, Scratch& scratch);

 private:
  std::vector<ContactKey> other_;      ///< As many as keys: by section when there are many.
  std::vector<std::uint32_t> counts_;  ///< Of chunks, by section.
  std::vector<std::size_t> ends_;
  std::span<ContactKey> sorted_;
  int section_bits_ = 0;  ///< Texel bits that are left to sort in a section; 0 = sorted.
};

}  // namespace patinate::simulation
