/// \file
/// What a full disk does to writers, without root.
#pragma once

#include <signal.h>
#include <sys/resource.h>

namespace patinate::testing_support {

/// While it lives, no file of this process grows beyond so many bytes: a write fails, with EFBIG.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limits = before_;
    limits.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limits);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    ::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace patinate::testing_support
