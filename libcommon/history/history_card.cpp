#include "libcommon/history/history_card.h"

#include <nlohmann/json.hpp>
#include <system_error>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace fs = std::filesystem;

std::optional<HistoryCard> read_history_card(const fs::path& folder) {
  const fs::path file = folder / kHistoryCardFile;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::nullopt;
  const Json root = load_json(file);
  JsonReader json(file.string(), root);
  json.expect_format("patinate.card", 1);
  HistoryCard card;
  card.title = json.member("title").string();
  if (json.has("about")) card.about = json.member("about").string();
  card.license = json.member("license").string();
  card.attribution = json.member("attribution").string();
  if (json.has("source")) card.source = json.member("source").string();
  json.finish();
  return card;
}

std::string credit_text(const HistoryCard& card) { return card.attribution + " (" + card.license + ")"; }

std::vector<std::string> credits_of(const fs::path& path) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path, error) ? path : folder_of(path);
  if (const std::optional<HistoryCard> card = read_history_card(folder)) return {credit_text(*card)};
  if (!fs::is_regular_file(folder / "run.json", error)) return {};
  try {
    const Json record = load_json(folder / "run.json");
    return record.is_object() && record.contains("credits") ? record["credits"].get<std::vector<std::string>>()
                                                            : std::vector<std::string>{};
  } catch (const IoError&) {
    return {};
  } catch (const Json::exception&) {
    return {};
  }
}

void add_credits(const fs::path& folder, const std::vector<std::string>& credits) {
  if (credits.empty()) return;
  Json record = load_json(folder / "run.json");
  record["credits"] = credits;
  save_json(folder / "run.json", record);
}

}  // namespace patinate
