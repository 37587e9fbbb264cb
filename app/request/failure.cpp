#include "app/request/failure.h"

#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "app/request/usage_error.h"
#include "patinate/core/error.h"

namespace patinate::app {

namespace {

constexpr int kCannot = 1, kUsage = 2, kInput = 3;

std::string message_of(const std::filesystem::filesystem_error& e) {
  const std::filesystem::path& path =
      e.path2().empty() ? e.path1() : e.path2();  // For a copy, the file that is written.
  return (path.empty() ? "the file system" : path.string()) + ": " + e.code().message();
}

/// nlohmann's "[json.exception.type_error.302] type must be string, but is null" without what is for programmers.
std::string message_of(const nlohmann::json::exception& e) {
  const std::string text = e.what();
  const std::size_t end = text.find("] ");
  return "does not hold what it should (" + (end == std::string::npos ? text : text.substr(end + 2)) +
         "); is it of another version, or changed by hand?";
}

}  // namespace

Failure current_failure() {
  try {
    throw;
  } catch (const UsageError& e) {
    return {kUsage, e.what()};
  } catch (const ParseError& e) {
    return {kUsage, e.what()};
  } catch (const InputError& e) {
    return {kInput, e.what()};
  } catch (const Error& e) {
    return {kCannot, e.what()};
  } catch (const std::bad_alloc&) {
    return {kCannot, "not enough memory; use a smaller image or atlas, or fewer threads"};
  } catch (const std::length_error&) {
    return {kCannot, "not enough memory: a file or an option asks for more than any computer has"};
  } catch (const nlohmann::json::exception& e) {
    return {kInput, "a JSON file " + message_of(e)};
  } catch (const std::filesystem::filesystem_error& e) {
    return {kCannot, message_of(e)};
  } catch (const std::system_error& e) {
    return {kCannot, "the system refuses: " + e.code().message()};
  } catch (const std::exception& e) {
    return {kCannot, "this should not happen, please report it with the command line: " + std::string(e.what())};
  } catch (...) {
    return {kCannot, "this should not happen, please report it with the command line"};
  }
}

void rethrow_naming(const std::filesystem::path& file) {
  try {
    throw;
  } catch (const Error&) {
    throw;
  } catch (const nlohmann::json::exception& e) {
    throw IoError(file.string(), message_of(e));
  } catch (...) {
    throw CannotComplete(file.string() + ": " + current_failure().message);
  }
}

}  // namespace patinate::app
