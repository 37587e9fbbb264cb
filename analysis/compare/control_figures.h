/// \file
/// Two surfaces by classes of a control: how far their colors and their rates of change are apart, class by class.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/figures/color_stack.h"
#include "analysis/figures/control_classes.h"
#include "analysis/figures/sliced_distance.h"

namespace patinate::analysis {

/// A surface whose texels belong to classes of a control.
class ClassedSurface {
 public:
  /// @param stack     Outlives this. @param block_of  Of every texel of the stack; outlives this.
  /// @param values    Of the control at the stack's texels, in [0, 1]. @param parameter  What 0 and 1 stand for.
  ClassedSurface(const ColorStack& stack, std::span<const std::uint16_t> block_of, std::vector<float> values,
                 const ControlFacts& parameter, const SharedControl& shared, int num_classes, std::uint64_t seed,
                 const RunControl& control = {});

  [[nodiscard]] std::size_t num_classes() const { return colors_.size(); }
  [[nodiscard]] const std::vector<float>& values() const { return values_; }
  /// Delta E 1976 of every texel from the first time to the last; empty with a single time.
  [[nodiscard]] const std::vector<float>& change() const { return change_; }
  /// Mean change per time of every class, Delta E 1976; nothing where a class has no weight.
  /// @param weights  How often each block counts.
  [[nodiscard]] std::vector<std::optional<double>> rates(std::span<const int> weights) const;
  /// Colors of a class at up to five of the times.
  [[nodiscard]] const std::vector<SortedColors>& colors(std::size_t k) const { return colors_[k]; }

 private:
  const ColorStack& stack_;
  std::span<const std::uint16_t> block_of_;
  std::vector<float> values_;
  std::vector<int> class_of_;
  std::vector<float> change_;
  std::vector<std::vector<SortedColors>> colors_;  ///< [class][time]
};

/// P(color | control, time): distance between the distributions, Delta E 1976, mean over the classes and times that
/// both have.
/// @returns nothing when they have none in common.
[[nodiscard]] std::optional<double> conditional_distance(const ClassedSurface& a, std::span<const int> weights_a,
                                                         const ClassedSurface& b, std::span<const int> weights_b);

/// Root mean square difference of the rates over the classes that both have. @returns nothing when there is none.
[[nodiscard]] std::optional<double> rate_distance(const ClassedSurface& a, std::span<const int> weights_a,
                                                  const ClassedSurface& b, std::span<const int> weights_b);

}  // namespace patinate::analysis
