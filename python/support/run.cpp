#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "python/support/keywords.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

using Work = std::function<void(const RunControl&)>;
constexpr std::chrono::milliseconds kBetweenLooks(10);
/// From the request to stop until work that owns what it uses is left behind; with a look and its start below 50 ms.
constexpr std::chrono::milliseconds kPatience(25);

/// One call's work on a thread of its own: what the working thread tells the waiting one.
class Worker {
 public:
  Worker(Work work, int num_threads, bool says_progress)
      : control_{.on_progress = {}, .stop = stop_.get_token(), .num_threads = num_threads} {
    if (says_progress) {
      control_.on_progress = [this](double fraction) {
        const std::lock_guard lock(mutex_);
        fraction_ = fraction;
      };
    }
    thread_ = std::thread([this, work = std::move(work)]() mutable { run(std::move(work)); });
  }

  void request_stop() { stop_.request_stop(); }
  /// @return  Whether it is done. Waits for that no longer than `time`.
  bool wait_for(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    return is_over_.wait_for(lock, time, [&] { return is_done_; });
  }
  /// < 0: nothing said yet.
  double fraction() {
    const std::lock_guard lock(mutex_);
    return fraction_;
  }
  /// Waits until it is done. @return  What it threw, if anything.
  std::exception_ptr join() {
    thread_.join();
    return problem_;
  }

 private:
  void run(Work work) {
    try {
      work(control_);
    } catch (...) {
      problem_ = std::current_exception();
    }
    work = {};  // Its memory is free again before anyone goes on.
    const std::lock_guard lock(mutex_);
    is_done_ = true;
    is_over_.notify_one();
  }

  std::stop_source stop_;
  RunControl control_;
  std::mutex mutex_;
  std::condition_variable is_over_;
  bool is_done_ = false;
  double fraction_ = -1.0;
  std::exception_ptr problem_;
  std::thread thread_;
};

/// Workers whose callers went on at Ctrl-C. Guarded by the interpreter's lock.
std::vector<std::unique_ptr<Worker>>& left_behind() {
  static auto* const workers = new std::vector<std::unique_ptr<Worker>>();  // Outlives every thread.
  return *workers;
}

/// Waits for it without the interpreter's lock.
bool wait_unlocked(Worker& worker, std::chrono::milliseconds time) {
  const py::gil_scoped_release others_run;
  return worker.wait_for(time);
}

std::exception_ptr join_unlocked(Worker& worker) {
  const py::gil_scoped_release others_run;
  return worker.join();
}

enum class AfterStop { Leave, Wait };

void run_on_thread(const RunArguments& arguments, Work work, AfterStop after) {
  auto worker = std::make_unique<Worker>(std::move(work), arguments.num_threads, !arguments.progress.is_none());
  std::exception_ptr raised;  // By `progress`, or KeyboardInterrupt.
  double told = -1.0;
  bool is_done = false;
  while (!is_done && !raised) {
    is_done = wait_unlocked(*worker, kBetweenLooks);
    const double fraction = worker->fraction();
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (fraction > told) arguments.progress(fraction);
      told = fraction;
    } catch (...) {
      raised = std::current_exception();
      worker->request_stop();
    }
  }
  std::exception_ptr problem;
  if (is_done || after == AfterStop::Wait || wait_unlocked(*worker, kPatience)) {
    problem = join_unlocked(*worker);
  } else {
    left_behind().push_back(std::move(worker));
  }
  if (!arguments.close.is_none()) arguments.close();
  if (raised) std::rethrow_exception(raised);
  if (problem) std::rethrow_exception(problem);
}

}  // namespace

void run_interruptibly(const RunArguments& arguments, Work work) {
  finish_left_work();
  run_on_thread(arguments, std::move(work), AfterStop::Leave);
}

void run_borrowing(const RunArguments& arguments, const Work& work) {
  finish_left_work();
  run_on_thread(arguments, work, AfterStop::Wait);
}

void finish_left_work() {
  std::vector<std::unique_ptr<Worker>>& workers = left_behind();
  while (!workers.empty()) {
    std::unique_ptr<Worker> worker = std::move(workers.back());
    workers.pop_back();
    while (!wait_unlocked(*worker, kBetweenLooks)) {
      if (PyErr_CheckSignals() == 0) continue;
      workers.push_back(std::move(worker));
      throw py::error_already_set();
    }
    (void)join_unlocked(*worker);  // Stopped, or done too late: nobody waits for what it says.
  }
}

}  // namespace patinate::python
