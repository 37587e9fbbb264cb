/// \file
/// Silence for libraries that log with glog (Ceres), which tell standard error what they also return.
#pragma once

#include <glog/logging.h>

#include <mutex>

namespace patinate {

/// While one lives, only fatal messages are logged. The level is global to the process, so that there is one at a time,
/// whoever asks. Only for .cpp files that link Ceres: nothing else here links glog.
class SilentLog {
 public:
  SilentLog() : lock_(mutex()), before_(FLAGS_minloglevel) { FLAGS_minloglevel = google::FATAL; }
  ~SilentLog() { FLAGS_minloglevel = before_; }
  SilentLog(const SilentLog&) = delete;
  SilentLog& operator=(const SilentLog&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  std::lock_guard<std::mutex> lock_;
  int before_;
};

}  // namespace patinate
