#include "libcommon/job/stage_run.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <system_error>

#include "libcommon/core/input_watch.h"
#include "libcommon/core/parallel.h"
#include "libcommon/job/undeclared_output.h"

namespace patinate {

namespace fs = std::filesystem;

ItemProgress::ItemProgress(const RunControl& control, const JobPlan& plan)
    : control_(control), fractions_(plan.items.size() + 1, 0.0) {
  for (const JobItem& item : plan.items) weights_.push_back(item.weight);
  weights_.push_back(plan.join_weight);
  total_weight_ = std::accumulate(weights_.begin(), weights_.end(), 0.0);
}

void ItemProgress::set(std::size_t item, double fraction) {
  if (!control_.on_progress) return;
  const std::lock_guard lock(mutex_);
  if (!(fraction > fractions_[item])) return;
  done_weight_ += weights_[item] * (fraction - fractions_[item]);
  fractions_[item] = fraction;
  const double total = done_weight_ / total_weight_;
  if (total > reported_ && total < 1.0) control_.report(reported_ = total);
}

RunControl ItemProgress::item_control(std::size_t item, int num_threads) {
  RunControl inner = control_;
  inner.num_threads = num_threads;
  inner.on_progress = [this, item](double f) { set(item, f); };
  return inner;
}

void run_side_by_side(const JobPlan& plan, std::span<const std::size_t> items, const fs::path& folder,
                      ItemProgress& progress, const RunControl& control,
                      const std::function<void(const JobItem&)>& finished,
                      const std::function<void(const JobItem&)>& written) {
  const InputStep looked_at_by_item(InputStep::Look::None);
  UndeclaredSearch undeclared(plan, folder, items.size());
  const int num_threads = thread_count(control);
  const int num_side_by_side =
      plan.parallel_items ? static_cast<int>(std::min<std::size_t>(items.size(), static_cast<std::size_t>(num_threads)))
                          : 1;
  RunControl workers;
  workers.stop = control.stop;
  workers.num_threads = std::max(1, num_side_by_side);
  const int threads_per_item = std::max(1, num_threads / workers.num_threads);
  parallel_for(static_cast<std::int64_t>(items.size()), 1, workers, [&](std::int64_t begin, std::int64_t) {
    const std::size_t i = items[begin];
    const JobItem& item = plan.items[i];
    control.throw_if_stopped();
    for (const fs::path& output : item.outputs) {
      std::error_code error;
      fs::create_directories((folder / output).parent_path(), error);
      if (error) throw CannotComplete((folder / output).string() + ": cannot be made; " + error.message());
    }
    const std::size_t begin_of_inputs = num_input_notes();
    item.run(folder, progress.item_control(i, threads_per_item));
    require_unchanged_inputs(begin_of_inputs);
    if (written) written(item);
    control.throw_if_stopped();  // Before what waits for the disk, which can take long.
    undeclared.finished(item.name, control);
    finished(item);
    progress.set(i, 1.0);
  });
}

}  // namespace patinate
