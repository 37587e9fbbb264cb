/// \file
/// Content keys: 128-bit XXH3 of everything that a result depends on, as 32 hexadecimal digits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace patinate {

/// Feeds values into one key. Every value comes with its length (a file, whose length is known
/// last, is followed by it), so that ("ab","c") differs from ("a","bc").
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(ContentHash&&) noexcept;
  ContentHash& operator=(ContentHash&&) noexcept;

  ContentHash& add(std::string_view text);
  ContentHash& add(std::span<const std::byte> bytes);
  ContentHash& add(double value);
  ContentHash& add(std::int64_t value);
  /// The file's bytes, not its name. @throws IoError if it cannot be read.
  ContentHash& add_file(const std::filesystem::path& path);
  [[nodiscard]] std::string hex() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Key of one file's bytes. @throws IoError
[[nodiscard]] std::string hash_file(const std::filesystem::path& path);

}  // namespace patinate
