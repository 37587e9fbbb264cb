#include "app/request/failure.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>
#include <type_traits>
#include <vector>

#include "app/request/usage_error.h"
#include "patinate/core/error.h"

namespace patinate {
namespace {

app::Failure failure_of(const std::function<void()>& throws) {
  try {
    throws();
  } catch (...) {
    return app::current_failure();
  }
  return {0, ""};
}

std::string named(const std::function<void()>& throws) {
  try {
    try {
      throws();
    } catch (...) {
      app::rethrow_naming("a.file");
    }
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Failure, OursKeepTheirWordsAndCodes) {
  EXPECT_EQ(failure_of([] { throw app::UsageError("a"); }).code, 2);
  EXPECT_EQ(failure_of([] { throw ParseError("a"); }).code, 2);
  EXPECT_EQ(failure_of([] { throw InvalidInput("a"); }).code, 3);
  EXPECT_EQ(failure_of([] { throw IoError("file", "is bad"); }).code, 3);
  EXPECT_EQ(failure_of([] { throw IoError("file", "is bad"); }).message, "file: is bad");
  EXPECT_EQ(failure_of([] { throw CannotComplete("a"); }).code, 1);
  EXPECT_EQ(named([] { throw IoError("file", "is bad"); }), "file: is bad");
}

// Code that names a file in front of what is wrong with a value relies on it: the file is named once.
TEST(Failure, WhatIsWrongWithAFileIsNoBrokenPrecondition) {
  static_assert(std::is_base_of_v<InputError, IoError> && !std::is_base_of_v<InvalidInput, IoError>);
  static_assert(std::is_base_of_v<InputError, ParseError> && !std::is_base_of_v<InvalidInput, ParseError>);
  static_assert(std::is_base_of_v<InputError, InvalidInput>);
  EXPECT_EQ(failure_of([] { throw InputError("a"); }).code, 3);
}

// Thrown by the libraries themselves, so that the words are those of the version that is built with.
TEST(Failure, WordsOfLibrariesBecomeOurs) {
  const auto wrong_type = [] { (void)nlohmann::json::parse("{\"a\": 1}").at("a").get<std::string>(); };
  const auto too_long = [] { std::vector<char>().resize(-1); };
  const auto no_memory = [] { throw std::bad_alloc(); };
  const auto no_folder = [] { std::filesystem::create_directory("/nowhere/at/all"); };
  const auto no_thread = [] { throw std::system_error(EAGAIN, std::generic_category()); };
  const auto bug = [] { (void)std::vector<int>().at(3); };
  EXPECT_EQ(failure_of(wrong_type).code, 3);
  EXPECT_EQ(failure_of(wrong_type).message,
            "a JSON file does not hold what it should (type must be string, but is number); is it of another version, "
            "or changed by hand?");
  EXPECT_EQ(failure_of(no_memory).code, 1);
  EXPECT_EQ(failure_of(too_long).code, 1);
  EXPECT_EQ(failure_of(no_folder).message, "/nowhere/at/all: No such file or directory");
  EXPECT_EQ(failure_of(no_thread).code, 1);
  EXPECT_EQ(failure_of(bug).code, 1);
  for (const auto& throws :
       std::vector<std::function<void()>>{wrong_type, too_long, no_memory, no_folder, no_thread, bug}) {
    EXPECT_EQ(failure_of(throws).message.find("json.exception"), std::string::npos);
    EXPECT_EQ(failure_of(throws).message.find("_M_default"), std::string::npos);
    EXPECT_EQ(named(throws).rfind("a.file: ", 0), 0u) << named(throws);
  }
  EXPECT_EQ(failure_of([] { throw 3; }).code, 1);
}

}  // namespace
}  // namespace patinate
