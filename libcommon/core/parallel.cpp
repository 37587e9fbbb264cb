#include "libcommon/core/parallel.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace patinate {

namespace {

/// Lets oneTBB keep as many threads as have ever been asked for: more than there are processors is slower, but what was
/// asked for.
void allow_threads(int num_threads) {
  static std::mutex mutex;
  static std::unique_ptr<tbb::global_control> limit;
  const std::lock_guard lock(mutex);
  using Limit = tbb::global_control;
  if (static_cast<int>(Limit::active_value(Limit::max_allowed_parallelism)) >= num_threads) return;
  limit = std::make_unique<Limit>(Limit::max_allowed_parallelism, static_cast<std::size_t>(num_threads));
}

/// The arena of the calling thread, which keeps a place in it whatever other callers do. Created again only when the
/// count changes.
tbb::task_arena& arena_of_this_thread(int num_threads) {
  thread_local std::unique_ptr<tbb::task_arena> arena;
  if (!arena || arena->max_concurrency() != num_threads) {
    allow_threads(num_threads);
    arena = std::make_unique<tbb::task_arena>(num_threads, 1);
  }
  return *arena;
}

thread_local bool is_inside_loop = false;

/// Runs `work`, which throws nothing, on the calling thread and on up to num_helpers threads of oneTBB's pool; returns
/// when all have come back.
void run_with_helpers(int num_helpers, int num_threads, const std::function<void()>& work) {
  // Writes of the caller before and reads afterward are ordered by this counter as well: the thread sanitizer does not
  // see into oneTBB.
  std::atomic<int> num_handed_over{0};
  const auto marked = [&] {
    num_handed_over.fetch_add(1);
    const bool was_inside = std::exchange(is_inside_loop, true);
    work();
    is_inside_loop = was_inside;
    num_handed_over.fetch_add(1);
  };
  // Isolated: a thread that waits for its own helpers must not take up another loop's work and come back late.
  const auto run = [&] {
    tbb::this_task_arena::isolate([&] {
      tbb::task_group helpers;
      for (int i = 0; i < num_helpers; ++i) helpers.run(marked);
      marked();
      helpers.wait();
    });
  };
  if (is_inside_loop) {
    run();  // a loop within a loop shares the outer one's threads
  } else {
    arena_of_this_thread(num_threads).execute(run);
  }
}

}  // namespace

int thread_count(const RunControl& control) {
  if (control.num_threads > 0) return control.num_threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallel_for(std::int64_t n, std::int64_t chunk_size, const RunControl& control,
                  const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (!(chunk_size > 0)) throw InvalidInput("parallel_for: chunk_size must be > 0");
  const std::int64_t num_chunks = n > 0 ? (n + chunk_size - 1) / chunk_size : 0;
  std::atomic<std::int64_t> next_chunk{0};
  std::atomic<std::int64_t> num_done{0};
  std::mutex mutex;
  std::exception_ptr first_error;
  std::int64_t first_error_chunk = num_chunks;
  double last_reported = 0.0;

  const auto work = [&] {
    while (!control.stop.stop_requested()) {
      const std::int64_t chunk = next_chunk.fetch_add(1);
      if (chunk >= num_chunks) return;
      try {
        body(chunk * chunk_size, std::min(n, (chunk + 1) * chunk_size));
        const double fraction = static_cast<double>(num_done.fetch_add(1) + 1) / static_cast<double>(num_chunks);
        if (control.on_progress) {
          const std::lock_guard lock(mutex);
          if (fraction < 1.0 && fraction > last_reported) control.report(last_reported = fraction);
        }
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (chunk < first_error_chunk) {
          first_error_chunk = chunk;
          first_error = std::current_exception();
        }
        next_chunk = num_chunks;
      }
    }
  };

  const int num_threads = thread_count(control);
  const int num_helpers = static_cast<int>(std::min<std::int64_t>(num_threads, num_chunks)) - 1;
  if (num_helpers < 1) {
    work();
  } else {
    run_with_helpers(num_helpers, num_threads, work);
  }
  if (first_error) std::rethrow_exception(first_error);
  control.throw_if_stopped();
  control.report(1.0);
}

}  // namespace patinate
