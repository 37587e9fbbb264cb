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

/// The command line is wrong (exit code 2).
class UsageError : public Error {
 public:
  using Error::Error;
};

/// A precondition on data or an option is broken (exit code 3).
class InvalidInput : public Error {
 public:
  using Error::Error;
};

/// A file cannot be read or does not hold what it should (exit code 3). what() begins with the path.
class IoError : public InvalidInput {
 public:
  IoError(const std::string& path, const std::string& problem) : InvalidInput(path + ": " + problem) {}
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
