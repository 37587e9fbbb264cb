#include "capture/project/photo_facts.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

constexpr const char* kNothing = "nothing said";

/// "a.jpg, b.jpg and 7 more".
std::string names_text(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more" : text;
}

/// Photographs by what they say, in the order in which it is first said.
class Said {
 public:
  void add(const std::string& text, const std::string& photo) {
    auto found = std::find_if(groups_.begin(), groups_.end(), [&](const auto& g) { return g.first == text; });
    if (found == groups_.end()) found = groups_.insert(groups_.end(), {text, {}});
    found->second.push_back(photo);
  }
  /// Text on what most say, and who says what else.
  [[nodiscard]] std::string text() const {
    const auto usual = std::max_element(groups_.begin(), groups_.end(),
                                        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    std::string line = usual->first;
    for (auto it = groups_.begin(); it != groups_.end(); ++it) {
      if (it != usual) line += "; not so in " + names_text(it->second) + ": " + it->first;
    }
    return line;
  }

 private:
  std::vector<std::pair<std::string, std::vector<std::string>>> groups_;
};

}  // namespace

std::vector<std::string> series_facts(const std::vector<std::pair<std::string, ImageFacts>>& photos) {
  std::vector<std::string> names;  // In the order of ImageFacts::named().
  for (const auto& [photo, facts] : photos) {
    for (const auto& [name, text] : facts.named()) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  std::vector<std::string> lines;
  for (const std::string& name : names) {
    Said said;
    for (const auto& [photo, facts] : photos) {
      const auto all = facts.named();
      const auto found = std::find_if(all.begin(), all.end(), [&](const auto& fact) { return fact.first == name; });
      said.add(found == all.end() ? kNothing : found->second, photo);
    }
    lines.push_back((name == "not_used" ? "not used" : name) + ": " + said.text());
  }
  return lines;
}

std::string override_text(const std::vector<std::pair<std::string, ImageFacts>>& photos, const Response& response) {
  if (response.kind == Response::Kind::File) return "";
  Said said;
  bool is_any = false;
  for (const auto& [photo, facts] : photos) {
    const bool is_same =
        facts.color.empty() || (facts.color.starts_with("sRGB") && response.kind == Response::Kind::Srgb);
    is_any = is_any || !is_same;
    said.add(facts.color.empty() ? kNothing : facts.color, photo);
  }
  return is_any ? "`response` " + response.text() +
                      " is used instead of what the photographs say of their color: " + said.text()
                : "";
}

std::string exposure_text(const ImageExposure& e) {
  if (!(e.amount() > 0.0)) return "";
  std::string text =
      e.time_s < 0.4 ? "1/" + short_number_text(std::round(1.0 / e.time_s)) + " s" : short_number_text(e.time_s) + " s";
  if (e.f_number > 0.0) text += ", f/" + short_number_text(e.f_number);
  return text + ", ISO " + short_number_text(e.iso);
}

}  // namespace patinate::capture
