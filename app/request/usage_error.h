/// \file
/// What is wrong with a command line itself.
#pragma once

#include "patinate/core/error.h"

namespace patinate::app {

/// The command line is wrong (exit code 2). what() begins with the argument that it is about.
class UsageError : public Error {
 public:
  using Error::Error;
};

}  // namespace patinate::app
