/// \file
/// What a history that is handed on says of itself beside its data: `card.json` in its folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace patinate {

/// The file in a history's folder.
inline constexpr const char* kHistoryCardFile = "card.json";

struct HistoryCard {
  std::string title;        ///< "Copper in vinegar and salt"
  std::string about;        ///< Description in a sentence; may be empty.
  std::string license;      ///< License as SPDX names it: "CC-BY-4.0".
  std::string attribution;  ///< The line that results carry.
  std::string source;       ///< Where it comes from, and what was done to it; may be empty.
};

/// @returns nothing when there is no card. @throws IoError if it breaks the format.
[[nodiscard]] std::optional<HistoryCard> read_history_card(const std::filesystem::path& folder);
/// "ATTRIBUTION (LICENSE)".
[[nodiscard]] std::string credit_text(const HistoryCard& card);

/// Whom a result owes: the card in its folder, or what the run.json there says of what it was made from; each once.
/// @param path  A folder, or a file in it. @throws IoError if a card breaks its format; other programs' run.json count
/// as none.
[[nodiscard]] std::vector<std::string> credits_of(const std::filesystem::path& path);

/// Says so in the run.json of a result. @throws IoError, CannotComplete
void add_credits(const std::filesystem::path& folder, const std::vector<std::string>& credits);

}  // namespace patinate
