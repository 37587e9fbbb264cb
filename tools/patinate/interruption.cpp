#include "tools/patinate/interruption.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <ctime>
#include <thread>

#include "libcommon/core/files.h"
#include "tools/patinate/message_stream.h"

namespace patinate {

namespace {

constexpr std::timespec kPatience{.tv_sec = 0, .tv_nsec = 25'000'000};

[[noreturn]] void end_at_once() {
  abandon_atomic_files();
  ::_exit(report_interruption());
}

}  // namespace

int report_interruption() {
  static std::atomic<bool> is_said = false;
  if (is_said.exchange(true)) return kInterruptedExitCode;
  if (::isatty(::fileno(message_stream())) != 0) std::fputs("\r\033[K", message_stream());  // Over a progress line.
  print_error("interrupted; nothing half-written is left, and the same command finishes the work");
  return kInterruptedExitCode;
}

void stop_on_signals(const std::stop_source& asked) {
  sigset_t signals;
  sigemptyset(&signals);
  bool is_any = false;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    // `nohup` and shells that start work in the background have it ignored: waiting for it would bring it back.
    if (::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
    sigaddset(&signals, signal);
    is_any = true;
  }
  if (!is_any) return;
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // inherited by every thread that starts later
  std::thread([signals, source = asked]() mutable {
    int signal = 0;
    while (sigwait(&signals, &signal) != 0) {
    }
    source.request_stop();
    (void)sigtimedwait(&signals, nullptr, &kPatience);
    end_at_once();
  }).detach();
}

}  // namespace patinate
