#include "tools/patinate/command_line/interruption.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <thread>

#include "libcommon/core/files.h"
#include "tools/patinate/command_line/message_stream.h"

namespace patinate::cli {

namespace {

std::atomic<std::chrono::nanoseconds> patience{std::chrono::milliseconds(25)};

std::timespec patience_as_timespec() {
  const std::chrono::nanoseconds all = patience.load();
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(all);
  return {.tv_sec = static_cast<std::time_t>(whole.count()), .tv_nsec = static_cast<long>((all - whole).count())};
}

[[noreturn]] void end_at_once() {
  abandon_atomic_files();
  ::_exit(report_interruption());
}

}  // namespace

int report_interruption() {
  static std::once_flag is_said;  // Whoever comes second waits for the line, and may end the process then.
  std::call_once(is_said, [] {
    if (::isatty(::fileno(message_stream())) != 0) std::fputs("\r\033[K", message_stream());  // Over a progress line.
    print_error("interrupted; nothing half-written is left, and the same command finishes the work");
  });
  return kInterruptedExitCode;
}

void take_time_to_end(std::chrono::nanoseconds longest) { patience = longest; }

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
    const std::timespec longest = patience_as_timespec();
    (void)sigtimedwait(&signals, nullptr, &longest);
    end_at_once();
  }).detach();
}

}  // namespace patinate::cli
