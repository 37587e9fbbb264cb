#include "tools/patinate/command_line/history_warnings.h"

#include <optional>

#include "tools/patinate/command_line/history_library.h"

namespace patinate::cli {

void note_history_warnings(CommandRun& run, const std::string& label, const std::vector<HistoryWarning>& warnings) {
  constexpr std::size_t kMost = 8;
  if (warnings.empty()) return;
  if (const std::optional<std::string> name = library_name(label)) {
    run.note(*name + ": " + std::to_string(warnings.size()) + (warnings.size() == 1 ? " warning" : " warnings") +
             " about its photographs: patinate info " + *name);
    return;
  }
  for (std::size_t i = 0; i < warnings.size() && i < kMost; ++i)
    run.note("warning: " + label + ": " + warning_text(warnings[i]));
  if (warnings.size() > kMost) run.note(std::to_string(warnings.size() - kMost) + " more warnings are in history.json");
}

}  // namespace patinate::cli
