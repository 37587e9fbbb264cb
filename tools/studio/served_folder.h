/// \file
/// The folder that the studio serves, and the rule that nothing outside it is touched.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace patinate::studio {

/// Names below it are relative, with `/`; they hold no `..`, and where links lead is looked at.
class ServedFolder {
 public:
  /// @throws IoError if it is no folder.
  explicit ServedFolder(const std::filesystem::path& folder);

  [[nodiscard]] const std::filesystem::path& path() const { return root_; }  ///< Canonical.
  /// Path below the folder by this name; "" and "." are the folder itself. Nothing if it is not there or lies
  /// outside.
  [[nodiscard]] std::optional<std::filesystem::path> find(std::string_view name) const;
  /// Path below `place`, which must not be left either. A place that is a file stands for its folder.
  [[nodiscard]] std::optional<std::filesystem::path> find_below(const std::filesystem::path& place,
                                                                std::string_view name) const;
  /// Where something new may be made: its folder exists inside, is no finished result (history, transfer, simulation,
  /// ...) nor part of one, and it does not exist. @throws InvalidInput that says what is wrong.
  [[nodiscard]] std::filesystem::path new_path(std::string_view name) const;
  /// Makes an empty file that was not there, in such a place: STEM.EXTENSION, or STEM-2.EXTENSION ... where that is
  /// taken.
  /// @param folder  Name of a folder. @throws InvalidInput; CannotComplete
  [[nodiscard]] std::filesystem::path make_file(std::string_view folder, const std::string& stem,
                                                const std::string& extension) const;
  /// The name of a path inside; "." for the folder itself.
  [[nodiscard]] std::string name_of(const std::filesystem::path& path) const;

 private:
  /// new_path() whether something is there or not.
  [[nodiscard]] std::filesystem::path writable_path(std::string_view name) const;

  std::filesystem::path root_;
};

}  // namespace patinate::studio
