#include "tools/patinate/command_line/message_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "libcommon/core/printable.h"
#include "patinate/core/error.h"

namespace patinate::cli {

namespace {
std::FILE* g_messages = stderr;
}

void silence_libraries() {
#ifndef PATINATE_IS_SANITIZED
  const int kept = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  std::FILE* messages = kept >= 0 && nowhere >= 0 ? ::fdopen(kept, "w") : nullptr;
  if (messages != nullptr && ::dup2(nowhere, STDERR_FILENO) >= 0) {
    std::setvbuf(messages, nullptr, _IONBF, 0);
    g_messages = messages;
  }
  if (nowhere >= 0) ::close(nowhere);
#endif
}

void print_result(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    throw CannotComplete("standard output: cannot be written; is the disk full?");
  }
}

std::string printable_json(const Json& json) {
  const auto text_of = [&](bool is_ascii) { return json.dump(2, ' ', is_ascii, Json::error_handler_t::replace); };
  std::string text = text_of(false);
  return printable_lines(text, text.size() + kLongestLine) == text ? text : text_of(true);
}

std::FILE* message_stream() { return g_messages; }

void print_error(std::string_view message) {
  std::fprintf(g_messages, "patinate: error: %s\n", printable_line(message).c_str());
}

void print_note(std::string_view text) { std::fprintf(g_messages, "%s\n", printable_lines(text).c_str()); }

}  // namespace patinate::cli
