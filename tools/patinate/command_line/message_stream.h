/// \file
/// Where our own lines on stderr go, apart from what libraries print there; and results, on stdout.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "patinate/core/json.h"

namespace patinate::cli {

/// Image libraries print on stderr what they throw or return as well; this keeps them quiet, so that an error is one
/// line. Call before any thread starts. Does nothing under sanitizers, whose reports go there too.
void silence_libraries();
/// Text on stdout, at once. @throws CannotComplete if it cannot be written.
void print_result(const std::string& text);
/// A result as `--json` prints it. Names keep their letters; where one holds what a terminal would obey, all that is
/// not ASCII is written as `\u009b`.
[[nodiscard]] std::string printable_json(const Json& json);
/// The real stderr.
[[nodiscard]] std::FILE* message_stream();
/// One line, `patinate: error: ...`, whatever is in the message (libcommon/core/printable.h).
void print_error(std::string_view message);
/// Lines that are no errors; what they quote from files is made printable too.
void print_note(std::string_view text);

}  // namespace patinate::cli
