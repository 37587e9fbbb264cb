/// \file
/// What went wrong, in our words.
#pragma once

#include <filesystem>
#include <string>

namespace patinate::app {

struct Failure {
  int code;             ///< Code of the process: 1 could not do it, 2 the command line is wrong, 3 the input is wrong.
  std::string message;  ///< For print_error().
};

/// Call in a `catch` block. Our own errors as they are; what a library throws translated, since its words name neither
/// the file nor what would be right. Canceled is no failure: catch it before.
[[nodiscard]] Failure current_failure();
/// Call in a `catch` block. The same error again; one that a library throws becomes ours, with the file that it is
/// about in front.
[[noreturn]] void rethrow_naming(const std::filesystem::path& file);

}  // namespace patinate::app
