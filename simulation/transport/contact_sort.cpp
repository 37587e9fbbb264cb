#include "simulation/transport/contact_sort.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate::simulation {

namespace {

constexpr std::size_t kFew = 32768;         ///< Below, one thread sorts faster than two begin to.
constexpr std::size_t kSectionKeys = 1024;  ///< Of few: about 100 us of work.
constexpr std::int64_t kChunk = 32768;      ///< Of many, for counting.
constexpr int kTileBits = 6;
constexpr int kTexelShift = 32;  ///< Of a key.
constexpr int kMaxDigit = 11;

/// Sorts by `bits` bits from `low`, stably, in as few passes of at most 11 bits as there can be. @returns whichever
/// holds the result.
std::span<ContactKey> radix_sort(std::span<ContactKey> keys, std::span<ContactKey> other, int low, int bits) {
  const int passes = (bits + kMaxDigit - 1) / kMaxDigit;
  for (int pass = 0; pass < passes; ++pass) {
    const int begin = low + bits * pass / passes;
    const int digit = low + bits * (pass + 1) / passes - begin;
    const ContactKey mask = (ContactKey{1} << digit) - 1;
    std::array<std::uint32_t, std::size_t{1} << kMaxDigit> at;
    std::fill_n(at.begin(), std::size_t{1} << digit, 0u);
    for (const ContactKey key : keys) ++at[key >> begin & mask];
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i <= mask; ++i) sum += std::exchange(at[i], sum);
    for (const ContactKey key : keys) other[at[key >> begin & mask]++] = key;
    std::swap(keys, other);
  }
  return keys;
}

}  // namespace

void ContactSort::cut(std::span<ContactKey> keys, std::uint32_t num_texels, const RunControl& control) {
  const int texel_bits = static_cast<int>(std::bit_width(std::max(num_texels, 2u) - 1));
  other_.resize(keys.size());
  ends_.assign(1, 0);
  if (keys.size() <= kFew) {
    section_bits_ = 0;
    sorted_ = radix_sort(keys, other_, kTexelShift, texel_bits);
    while (ends_.back() < sorted_.size()) {
      std::size_t end = std::min(ends_.back() + kSectionKeys, sorted_.size());
      const auto tile = [&](std::size_t i) { return sorted_[i] >> (kTexelShift + kTileBits); };
      while (end < sorted_.size() && tile(end) == tile(end - 1)) ++end;
      ends_.push_back(end);
    }
    return;
  }
  // By the texels' top bits first: stable, since chunks count in order.
  section_bits_ = std::max(kTileBits, texel_bits - kMaxDigit + 1);
  const int shift = kTexelShift + section_bits_;
  const std::size_t num = (std::size_t{num_texels - 1} >> section_bits_) + 1;
  const auto n = static_cast<std::int64_t>(keys.size());
  const std::int64_t num_chunks = (n + kChunk - 1) / kChunk;
  counts_.assign(num * static_cast<std::size_t>(num_chunks), 0);
  parallel_for(n, kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    std::uint32_t* counts = counts_.data() + num * static_cast<std::size_t>(begin / kChunk);
    for (std::int64_t i = begin; i < end; ++i) ++counts[keys[static_cast<std::size_t>(i)] >> shift];
  });
  std::uint32_t sum = 0;
  for (std::size_t s = 0; s < num; ++s) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(num_chunks); ++c)
      sum += std::exchange(counts_[c * num + s], sum);
    ends_.push_back(sum);
  }
  parallel_for(n, kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    std::uint32_t* at = counts_.data() + num * static_cast<std::size_t>(begin / kChunk);
    for (std::int64_t i = begin; i < end; ++i) {
      const ContactKey key = keys[static_cast<std::size_t>(i)];
      other_[at[key >> shift]++] = key;
    }
  });
  sorted_ = other_;
}

std::span<const ContactKey> ContactSort::sort_section(std::int64_t section, Scratch& scratch) {
  const std::size_t begin = begin_of(section);
  const std::span<ContactKey> keys = sorted_.subspan(begin, begin_of(section + 1) - begin);
  if (section_bits_ == 0 || keys.size() < 2) return keys;
  if (scratch.size() < keys.size()) scratch.resize(keys.size());
  return radix_sort(keys, std::span(scratch).first(keys.size()), kTexelShift, section_bits_);
}

}  // namespace patinate::simulation
