/// \file
/// Real data that stays outside the repository, in $PATINATE_DATA.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

namespace patinate::testing_support {

/// $PATINATE_DATA / name if the variable is set and the path exists.
[[nodiscard]] std::optional<std::filesystem::path> real_data(const std::filesystem::path& name);

}  // namespace patinate::testing_support

/// Skips the test, saying so, when the data is absent; else defines `variable` as its path.
#define PATINATE_REQUIRE_DATA(variable, name)                                    \
  const auto variable##_found = patinate::testing_support::real_data(name);      \
  if (!variable##_found) GTEST_SKIP() << "PATINATE_DATA does not hold " << name; \
  const std::filesystem::path variable = *variable##_found
