/// \file
/// The errors that patinate throws. All are caught once, in main(), and become one line on stderr and an exit code.
#pragma once

#include <stdexcept>
#include <string>

namespace patinate {

/// Base of all errors. what() is one line: `SUBJECT: what is wrong; what would be right`.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An input is wrong: base of the three errors that say how. Catch it to treat them alike.
class InputError : public Error {
 public:
  using Error::Error;
};

/// A precondition on data or an option is broken (exit code 3).
class InvalidInput : public InputError {
 public:
  using InputError::InputError;
};

/// A text that a person writes cannot be understood: an expression, a control, a range, the extension of an output
/// (exit code 2, as for the rest of a command line). Whoever reads such a text from a file makes it an IoError.
class ParseError : public InputError {
 public:
  using InputError::InputError;
};

/// A file cannot be read or does not hold what it should (exit code 3). what() begins with the path.
class IoError : public InputError {
 public:
  IoError(const std::string& path, const std::string& problem) : InputError(path + ": " + problem) {}
};

/// Valid work that could not be done: disk full, a different output in the way (exit code 1).
class CannotComplete : public Error {
 public:
  using Error::Error;
};

/// The caller asked to stop (exit code 130). Nothing half-written is left.
class Canceled : public Error {
 public:
  Canceled() : Error("interrupted") {}
};

}  // namespace patinate
