#include "tools/patinate/command_line/planned_command.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "libcommon/core/text.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/command_line/verbs.h"

namespace patinate::cli {

namespace {

/// Those that tell, serve, or are done before it is known what they would make.
constexpr std::array<std::string_view, 12> kUnplanned{"devices", "init", "calibrate", "studio",     "info", "validate",
                                                      "plan",    "run",  "join",      "completion", "help", "study"};

}  // namespace

bool is_planned(const std::string& verb) {
  const std::span<const Verb> all = verbs();
  return std::any_of(all.begin(), all.end(), [&](const Verb& v) { return v.name == verb; }) &&
         std::find(kUnplanned.begin(), kUnplanned.end(), verb) == kUnplanned.end();
}

int ask_command(const std::vector<std::string>& words, PlanRequest& request, std::stop_token stop, bool& is_json) {
  std::vector<std::string> names;
  for (const Verb& verb : verbs()) {
    if (is_planned(verb.name)) names.emplace_back(verb.name);
    if (words.front() != verb.name) continue;
    if (!is_planned(verb.name))
      throw UsageError(words.front() + ": cannot be planned; it makes no output in steps that are known before");
    CommandRun run(verb.name, verb.brief, {words.begin() + 1, words.end()}, std::move(stop));
    run.answer(request);
    const int code = verb.run(run);
    is_json = run.line.common().json;
    return code;
  }
  throw UsageError(words.front() + ": no such command" + did_you_mean(words.front(), names) +
                   "; see `patinate --help`");
}

std::vector<std::string> without_manners(const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 5> kFlags{"--json", "--quiet", "--verbose", "--dry-run", "--dry_run"};
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (std::find(kFlags.begin(), kFlags.end(), words[i]) != kFlags.end() || words[i].starts_with("--threads="))
      continue;
    if (words[i] == "--threads") {
      ++i;
      continue;
    }
    kept.push_back(words[i]);
  }
  return kept;
}

}  // namespace patinate::cli
