/// \file
/// What work costs in a process of its own: its processor time and its peak memory, whatever else runs beside it.
#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

namespace patinate::benchmarks {

struct ChildCost {
  double cpu_s = -1.0;   ///< User and system, all threads; < 0 when the work failed.
  double peak_mb = 0.0;  ///< Resident.
};

/// Runs `work` in a child. Call it before this process has started threads.
[[nodiscard]] inline ChildCost cost_in_child(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    work();
    ::_exit(0);
  }
  int status = 0;
  struct rusage usage {};
  ::wait4(child, &status, 0, &usage);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return {};
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime),
          .peak_mb = static_cast<double>(usage.ru_maxrss) / 1024.0};
}

}  // namespace patinate::benchmarks
