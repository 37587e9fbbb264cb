/// \file
/// Items of one stage of a plan, side by side, and their progress: what run_job() and run_spread_items() share.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "libcommon/job/job.h"

namespace patinate {

/// Progress of items that run side by side as one rising fraction. The join counts as one more item.
class ItemProgress {
 public:
  /// @param control, plan  Must outlive this.
  ItemProgress(const RunControl& control, const JobPlan& plan);

  void set(std::size_t item, double fraction);
  [[nodiscard]] RunControl item_control(std::size_t item, int num_threads);

 private:
  const RunControl& control_;
  std::mutex mutex_;
  std::vector<double> fractions_, weights_;
  double total_weight_ = 0.0;
  double done_weight_ = 0.0;
  double reported_ = 0.0;
};

/// Runs items of one stage in `folder`, as many at a time as the plan and the control allow.
/// @param items  Indices into plan.items. @param finished  Called when all of an item's files are written, from any
/// thread. @param written  Empty, or called before, and also when the run is stopped just then: nothing long.
/// @throws UndeclaredOutput if an item wrote what it did not declare; what items and `finished` throw; Canceled.
void run_side_by_side(const JobPlan& plan, std::span<const std::size_t> items, const std::filesystem::path& folder,
                      ItemProgress& progress, const RunControl& control,
                      const std::function<void(const JobItem&)>& finished,
                      const std::function<void(const JobItem&)>& written = {});

}  // namespace patinate
