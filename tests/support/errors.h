/// \file
/// What a call that must fail says.
#pragma once

#include <string>

#include "patinate/core/error.h"

namespace patinate::testing_support {

/// Message of the error that `call` throws; "" when it throws none. Other exceptions than Expected continue.
template <class Expected = InputError, class Call>
[[nodiscard]] std::string error_of(Call&& call) {
  try {
    call();
  } catch (const Expected& e) {
    return e.what();
  }
  return "";
}

[[nodiscard]] inline bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace patinate::testing_support
