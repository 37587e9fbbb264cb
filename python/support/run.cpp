#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "python/support/keywords.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

/// What the working thread tells the waiting one.
struct Watched {
  std::mutex mutex;
  std::condition_variable is_over;
  bool is_done = false;
  double fraction = -1.0;  ///< < 0: nothing said yet.
  std::exception_ptr problem;

  void work(const std::function<void(const RunControl&)>& function, const RunControl& control) {
    try {
      function(control);
    } catch (...) {
      problem = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    is_done = true;
    is_over.notify_one();
  }
};

}  // namespace

void run_interruptibly(const RunArguments& arguments, const std::function<void(const RunControl&)>& work) {
  constexpr std::chrono::milliseconds kBetweenLooks(10);
  Watched watched;
  std::stop_source stop;
  RunControl control{.on_progress = {}, .stop = stop.get_token(), .num_threads = arguments.num_threads};
  if (!arguments.progress.is_none()) {
    control.on_progress = [&](double fraction) {
      const std::lock_guard lock(watched.mutex);
      watched.fraction = fraction;
    };
  }
  std::thread worker([&] { watched.work(work, control); });
  std::exception_ptr raised;  // By `progress`, or KeyboardInterrupt.
  double told = -1.0;
  bool is_done = false;
  while (!is_done && !raised) {
    double fraction = 0.0;
    {
      const py::gil_scoped_release others_run;
      std::unique_lock lock(watched.mutex);
      watched.is_over.wait_for(lock, kBetweenLooks, [&] { return watched.is_done; });
      is_done = watched.is_done;
      fraction = watched.fraction;
    }
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (fraction > told) arguments.progress(fraction);
      told = fraction;
    } catch (...) {
      raised = std::current_exception();
      stop.request_stop();
    }
  }
  {
    const py::gil_scoped_release others_run;
    worker.join();
  }
  if (!arguments.close.is_none()) arguments.close();
  if (raised) std::rethrow_exception(raised);
  if (watched.problem) std::rethrow_exception(watched.problem);
}

}  // namespace patinate::python
