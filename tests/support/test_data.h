/// \file
/// Real data that stays outside the repository, in $PATINATE_DATA; and what runs nightly only, where $PATINATE_NIGHTLY
/// is set.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

namespace patinate::testing_support {

/// $PATINATE_DATA / name if the variable is set and the path exists.
[[nodiscard]] std::optional<std::filesystem::path> real_data(const std::filesystem::path& name);

/// Whether tests run at their full length: $PATINATE_NIGHTLY is set and not empty.
[[nodiscard]] bool is_nightly();

/// How many samples of something random a test draws: `full` nightly, a tenth per commit. Bounds follow from the
/// number.
template <class Count>
[[nodiscard]] Count sample_count(Count full) {
  return is_nightly() ? full : full / 10;
}

}  // namespace patinate::testing_support

/// Skips the test, saying so, when the set that runs is not the nightly one.
#define PATINATE_NIGHTLY_ONLY() \
  if (!patinate::testing_support::is_nightly()) GTEST_SKIP() << "runs nightly"

/// Skips the test, saying so, when the data is absent; else defines `variable` as its path.
#define PATINATE_REQUIRE_DATA(variable, name)                                    \
  const auto variable##_found = patinate::testing_support::real_data(name);      \
  if (!variable##_found) GTEST_SKIP() << "PATINATE_DATA does not hold " << name; \
  const std::filesystem::path variable = *variable##_found
