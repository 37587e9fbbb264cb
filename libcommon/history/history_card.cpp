#include "libcommon/history/history_card.h"

#include <nlohmann/json.hpp>
#include <system_error>

#include "libcommon/core/files.h"
#include "libcommon/document/document.h"
#include "libcommon/history/history_documents.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr DocumentKind kCardDocument{
    .format = "patinate.card",
    .title = "patinate history card",
    .about = "card.json: what a history that is handed on says of itself, beside its history.json."};

}  // namespace

void describe(DocumentVisitor& v, HistoryCard& card) {
  v.member({"title", "For people."}, card.title);
  v.member(if_set("about", "What is seen, in a sentence."), card.about);
  v.member({"license", "As SPDX names it: CC-BY-4.0."}, card.license);
  v.member({"attribution", "The line that results carry."}, card.attribution);
  v.member(if_set("source", "Where it comes from, and what was done to it."), card.source);
}

std::optional<HistoryCard> read_history_card(const fs::path& folder) {
  const fs::path file = folder / kHistoryCardFile;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::nullopt;
  HistoryCard card;
  read_document(kCardDocument, file, described(card));
  return card;
}

Json history_card_schema() { return document_schema(kCardDocument, described<HistoryCard>()); }

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
