#include "tools/patinate/command_line/planned_command.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "app/request/usage_error.h"
#include "tools/patinate/command_line/verbs.h"

namespace patinate::cli {

int ask_command(const std::vector<std::string>& words, PlanRequest& request, std::stop_token stop, bool& is_json) {
  const std::optional<FoundVerb> found = find_verb(words);
  if (!found) fail_no_verb(words);
  const Verb& verb = *found->verb;
  if (!verb.is_planned)
    throw app::UsageError(std::string(verb.name) +
                          ": cannot be planned; it makes no output in steps that are known before");
  CommandRun run(verb.name, verb.brief, {words.begin() + static_cast<std::ptrdiff_t>(found->num_words), words.end()},
                 std::move(stop));
  run.answer(request);
  const int code = verb.run(run);
  run.note_advice();
  is_json = run.line.common().json;
  return code;
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
