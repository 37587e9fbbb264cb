#include "tools/patinate/commands/command_words.h"

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "patinate/history/history.h"

namespace patinate::cli {

app::Words words_of(CommandRun& run) {
  const auto mutex = std::make_shared<std::mutex>();
  const auto in_turn = [mutex](auto&& say) {
    return [mutex, say](const std::string& text) {
      const std::lock_guard lock(*mutex);
      say(text);
    };
  };
  return {.detail = in_turn([&run](const std::string& text) { run.detail(text); }),
          .note = in_turn([&run](const std::string& text) { run.note(text); }),
          .warning = in_turn([&run](const std::string& text) { run.warn(text); }),
          .decided =
              [mutex, &run](const std::string& option, const std::string& value) {
                const std::lock_guard lock(*mutex);
                run.line.decided(option, value);
              },
          .phase = [&run](const std::string& name) { return run.control(name); },
          .is_dry_run = run.line.common().dry_run};
}

Json frames_json(const std::filesystem::path& folder) {
  const HistoryManifest made = read_history_manifest(folder);
  return {{"frames", made.frames.size()},
          {"first_time", made.frames.front().time},
          {"last_time", made.frames.back().time},
          {"time_unit", time_unit_text(made.time_unit)}};
}

}  // namespace patinate::cli
