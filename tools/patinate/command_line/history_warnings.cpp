#include "tools/patinate/command_line/history_warnings.h"

#include "app/request/history_library.h"
#include "app/request/repeating_command.h"

namespace patinate::cli {

void say_history_warnings(CommandRun& run, const std::string& label, const std::vector<HistoryWarning>& warnings) {
  constexpr std::size_t kMost = 8;
  for (std::size_t i = 0; i < warnings.size() && i < kMost; ++i) run.warn(label + ": " + warning_text(warnings[i]));
  if (warnings.size() > kMost) run.note(std::to_string(warnings.size() - kMost) + " more warnings are in history.json");
}

std::string history_warnings_line(const std::string& label, const std::vector<HistoryWarning>& warnings) {
  if (warnings.empty()) return "";
  const std::string name = app::library_name(label).value_or(label);
  return name + " has " + std::to_string(warnings.size()) + (warnings.size() == 1 ? " warning" : " warnings") +
         " about its photographs; `patinate info " + app::shell_word(name) + "` lists them";
}

void refer_to_history_warnings(CommandRun& run, const std::string& label, const std::vector<HistoryWarning>& warnings) {
  if (!warnings.empty()) run.note(history_warnings_line(label, warnings));
}

}  // namespace patinate::cli
