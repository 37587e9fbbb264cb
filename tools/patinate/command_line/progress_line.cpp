#include "tools/patinate/command_line/progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "libcommon/core/printable.h"
#include "tools/patinate/command_line/message_stream.h"
#include "tools/patinate/command_line/studio_job.h"

namespace patinate::cli {

namespace {

constexpr auto kTerminalInterval = std::chrono::milliseconds(100);
constexpr auto kPlainInterval = std::chrono::seconds(10);
constexpr auto kStudioInterval = std::chrono::milliseconds(500);
constexpr int kBarWidth = 30;
constexpr std::size_t kLongestLabel = 200;

std::string left_text(std::optional<double> left) {
  if (!left) return "";
  const int seconds = static_cast<int>(std::lround(std::min(*left, 359999.0)));
  char text[32];
  std::snprintf(text, sizeof text, ", %d:%02d left", seconds / 60, seconds % 60);
  return text;
}

}  // namespace

ProgressLine::ProgressLine(const std::string& label)
    : label_(printable_line(label, kLongestLabel)),
      is_terminal_(::isatty(::fileno(message_stream())) != 0),
      interval_(is_terminal_      ? Clock::duration(kTerminalInterval)
                : is_studio_job() ? Clock::duration(kStudioInterval)
                                  : Clock::duration(kPlainInterval)) {}

ProgressLine::~ProgressLine() {
  if (is_shown_ && is_terminal_) std::fputs("\r\033[K", message_stream());
}

void ProgressLine::show(double fraction) {
  const auto now = Clock::now();
  left_.add(std::chrono::duration<double>(now - begin_).count(), fraction);
  if (now - last_ < interval_) return;
  last_ = now;
  is_shown_ = true;
  const int percent = static_cast<int>(100.0 * std::clamp(fraction, 0.0, 1.0));
  const std::string left = left_text(left_.seconds());
  if (is_terminal_) {
    std::string bar(kBarWidth, ' ');
    std::fill_n(bar.begin(), kBarWidth * percent / 100, '#');
    std::fprintf(message_stream(), "\r%s [%s] %d %%%s\033[K", label_.c_str(), bar.c_str(), percent, left.c_str());
    std::fflush(message_stream());
  } else {
    std::fprintf(message_stream(), "%s: %d %%%s\n", label_.c_str(), percent, left.c_str());
  }
}

}  // namespace patinate::cli
