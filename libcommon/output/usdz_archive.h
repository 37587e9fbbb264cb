/// \file
/// The package of a .usdz: a zip whose files lie as they are, each from a multiple of 64 bytes on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace patinate {

/// Writes files one after the other. No dates: equal files give equal bytes.
class UsdzArchive {
 public:
  /// @throws CannotComplete
  explicit UsdzArchive(const std::filesystem::path& path);
  /// @param name  Within the package. @throws CannotComplete if the package would pass 4 GiB, or on a full disk;
  /// IoError.
  void add(const std::string& name, const std::filesystem::path& file);
  /// After the last one. @throws CannotComplete
  void finish();

 private:
  struct Entry {
    std::string name;
    std::uint32_t crc = 0, size = 0, offset = 0;
  };
  void write(const std::string& bytes);

  std::filesystem::path path_;
  std::ofstream out_;
  std::uint64_t position_ = 0;
  std::vector<Entry> entries_;
};

}  // namespace patinate
