/// \file
/// Some of an atlas's texels, ascending and numbered, in 3 bits each of the atlas's.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/atlas/texel_map.h"

namespace patinate {

/// A bit a texel, and before every 64 of them how many there are: what a list of 8 bytes a member and a table of 4
/// bytes a texel would say.
class TexelSet {
 public:
  TexelSet() = default;
  /// @param num_texels  Of the atlas, at most 2^32. @param is_member  Asked once of each, by several threads at once.
  /// @throws Canceled
  template <class IsMember>
  TexelSet(std::int64_t num_texels, const IsMember& is_member, const RunControl& control)
      : words_(static_cast<std::size_t>((num_texels + 63) / 64)), before_(words_.size()) {
    parallel_for(num_texels, kChunk, control, [&](TexelId begin, TexelId end) { insert_some(begin, end, is_member); });
    count();
  }
  /// @param members  In any order, each in [0, num_texels); some may stand there more than once.
  TexelSet(std::int64_t num_texels, std::span<const TexelId> members)
      : words_(static_cast<std::size_t>((num_texels + 63) / 64)), before_(words_.size()) {
    for (const TexelId t : members) insert(t);
    count();
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool contains(TexelId t) const {
    return (words_[static_cast<std::size_t>(t) / 64] >> (t % 64) & 1) != 0;
  }
  /// How many members come before `t`.
  [[nodiscard]] std::size_t index_of(TexelId t) const {
    const auto word = static_cast<std::size_t>(t) / 64;
    return before_[word] + static_cast<std::size_t>(std::popcount(words_[word] & ((std::uint64_t{1} << (t % 64)) - 1)));
  }

  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = TexelId;
    using difference_type = std::ptrdiff_t;
    using pointer = const TexelId*;
    using reference = TexelId;
    Iterator() = default;
    [[nodiscard]] TexelId operator*() const { return static_cast<TexelId>(word_ * 64) + std::countr_zero(rest_); }
    Iterator& operator++() {
      rest_ &= rest_ - 1;
      skip_empty();
      return *this;
    }
    Iterator operator++(int) {
      const Iterator before = *this;
      ++*this;
      return before;
    }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.word_ == b.word_ && a.rest_ == b.rest_; }

   private:
    friend class TexelSet;
    Iterator(const TexelSet& set, std::size_t word)
        : words_(&set.words_), word_(word), rest_(word < words_->size() ? (*words_)[word] : 0) {
      skip_empty();
    }
    void skip_empty() {
      while (rest_ == 0 && word_ < words_->size() && ++word_ < words_->size()) rest_ = (*words_)[word_];
    }
    const std::vector<std::uint64_t>* words_ = nullptr;
    std::size_t word_ = 0;
    std::uint64_t rest_ = 0;
  };
  [[nodiscard]] Iterator begin() const { return {*this, 0}; }
  [[nodiscard]] Iterator end() const { return {*this, words_.size()}; }
  /// From the member with that number on; end() after the last. O(log num_texels).
  [[nodiscard]] Iterator from(std::size_t index) const {
    if (index >= size_) return end();
    const auto after = std::upper_bound(before_.begin(), before_.end(), index);
    const auto word = static_cast<std::size_t>(after - before_.begin()) - 1;
    Iterator at(*this, word);
    for (std::size_t i = before_[word]; i < index; ++i) ++at;
    return at;
  }
  [[nodiscard]] TexelId operator[](std::size_t index) const { return *from(index); }

 private:
  static constexpr std::int64_t kChunk = 1 << 16;  ///< Texels a thread asks of at a time.

  /// Those of [begin, end) that are members; words at its ends may be another thread's as well.
  template <class IsMember>
  void insert_some(TexelId begin, TexelId end, const IsMember& is_member) {
    for (TexelId t = begin; t < end;) {
      const TexelId word = t / 64, stop = std::min(end, (word + 1) * 64);
      std::uint64_t bits = 0;
      for (; t < stop; ++t) bits |= is_member(t) ? std::uint64_t{1} << (t % 64) : 0;
      if (bits != 0) std::atomic_ref(words_[word]).fetch_or(bits, std::memory_order_relaxed);
    }
  }
  void insert(TexelId t) { words_[static_cast<std::size_t>(t) / 64] |= std::uint64_t{1} << (t % 64); }
  void count() {
    for (std::size_t word = 0; word < words_.size(); ++word) {
      before_[word] = static_cast<std::uint32_t>(size_);
      size_ += static_cast<std::size_t>(std::popcount(words_[word]));
    }
  }

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> before_;  ///< Members in all words before.
  std::size_t size_ = 0;
};

}  // namespace patinate
