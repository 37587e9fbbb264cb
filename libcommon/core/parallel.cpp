#include "libcommon/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

namespace patinate {

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

  const std::int64_t num_threads = std::min<std::int64_t>(thread_count(control), num_chunks);
  {
    std::vector<std::jthread> helpers;
    for (std::int64_t i = 1; i < num_threads; ++i) helpers.emplace_back(work);
    work();
  }
  if (first_error) std::rethrow_exception(first_error);
  control.throw_if_stopped();
  control.report(1.0);
}

}  // namespace patinate
