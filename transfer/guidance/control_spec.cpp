#include <algorithm>
#include <vector>

#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/transfer/control_matching.h"

namespace patinate::transfer {

namespace {

/// Where a character stands outside of parentheses and quotes; npos if nowhere.
std::size_t find_outside(std::string_view text, char c) {
  int depth = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') is_quoted = !is_quoted;
    if (is_quoted) continue;
    depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
    if (text[i] == c && depth <= 0) return i;
  }
  return std::string_view::npos;
}

/// split(text, ':') outside of parentheses and quotes.
std::vector<std::string> split_outside(std::string_view text) {
  std::vector<std::string> parts;
  for (std::size_t at = find_outside(text, ':'); at != std::string_view::npos; at = find_outside(text, ':')) {
    parts.push_back(split(text.substr(0, at), '\0').front());
    text.remove_prefix(at + 1);
  }
  parts.push_back(split(text, '\0').front());
  return parts;
}

}  // namespace

ControlSpec parse_control_spec(std::string_view text) {
  const auto fail = [&](const std::string& problem) -> ControlSpec {
    throw ParseError("--control " + std::string(text) + ": " + problem +
                     "; use [SOURCE=]DESTINATION[:weight[:mapping]]");
  };
  ControlSpec spec;
  std::string_view rest = text;
  if (const std::size_t equals = find_outside(rest, '='); equals != std::string_view::npos) {
    spec.source = rest.substr(0, equals);
    if (!is_file_name(spec.source)) return fail("`" + spec.source + "` is no control name");
    rest.remove_prefix(equals + 1);
  }
  const std::vector<std::string> parts = split_outside(rest);
  if (parts.size() > 3) return fail("too many `:`");
  spec.destination = parts[0];
  if (spec.destination.empty()) return fail("the destination is missing");
  if (parts.size() > 1) {
    const auto weight = parse_number(parts[1]);
    if (!weight || !(*weight > 0.0)) return fail("weight `" + parts[1] + "` is no number > 0");
    spec.weight = *weight;
  }
  if (parts.size() > 2) {
    const auto it = std::find(kControlMappingNames.begin(), kControlMappingNames.end(), parts[2]);
    if (it != kControlMappingNames.end()) {
      spec.mapping = static_cast<ControlMapping>(it - kControlMappingNames.begin());
    } else if (parts[2] != "auto") {
      std::vector<std::string> names(kControlMappingNames.begin(), kControlMappingNames.end());
      names.emplace_back("auto");
      return fail("unknown mapping `" + parts[2] + "`" + did_you_mean(parts[2], names) +
                  " (auto, rank, linear, physical)");
    }
  }
  return spec;
}

std::string source_control(const History& history, const ControlSpec& spec) {
  if (!spec.source.empty()) return history.control(spec.source).name;
  const auto& controls = history.facts().controls;
  if (controls.size() == 1) return controls[0].name;
  if (controls.size() == 2 && !history.facts().parts.empty())
    return controls[controls[0].name == kLibraryControl ? 1 : 0].name;
  std::string names;
  for (const ControlFacts& c : controls) names += (names.empty() ? "" : ", ") + c.name;
  throw ParseError("--control " + spec.destination + ": " + history.label() +
                   (controls.empty() ? " has no controls; ingest with one"
                                     : " has several controls (" + names + "); write SOURCE=" + spec.destination));
}

}  // namespace patinate::transfer
