// The one place where errors become a line on stderr and an exit code.
#include <signal.h>

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/request/failure.h"
#include "app/request/usage_error.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate_commit.h"
#include "tools/patinate/command_line/interruption.h"
#include "tools/patinate/command_line/message_stream.h"
#include "tools/patinate/command_line/studio_job.h"
#include "tools/patinate/command_line/verbs.h"

namespace patinate::cli {
namespace {

constexpr int kDone = 0;

/// Commands that show or run what changes while they do.
bool lives_on(const std::string& verb) { return verb == "studio" || verb == "study"; }

int run_verb(const std::vector<std::string>& arguments, std::stop_token stop) {
  if (arguments.empty()) throw app::UsageError("no command is given; see `patinate --help`");
  const std::string& name = arguments.front();
  if (name == "--help" || name == "-h") {
    print_result(overview());
    return kDone;
  }
  if (name == "--version") {
    print_result("patinate " PATINATE_VERSION " (" PATINATE_COMMIT ", " PATINATE_BUILD ")\n");
    return kDone;
  }
  const std::optional<FoundVerb> found = find_verb(arguments);
  if (!found) {
    const bool is_help = arguments.size() > 1 && (arguments[1] == "--help" || arguments[1] == "-h");
    if (!is_help || parts_of(name).empty()) fail_no_verb(arguments);
    print_result(overview_of(name));
    return kDone;
  }
  const Verb& verb = *found->verb;
  std::optional<InputWatch> watch;
  if (!lives_on(verb.name)) watch.emplace();
  CommandRun run(verb.name, verb.brief,
                 {arguments.begin() + static_cast<std::ptrdiff_t>(found->num_words), arguments.end()}, std::move(stop));
  const int code = verb.run(run);
  run.note_advice();
  if (found->former != nullptr)
    run.note(std::string("`patinate ") + found->former + "` is now `patinate " + verb.name + "`");
  return code;
}

int guarded_main(const std::vector<std::string>& arguments) {
  silence_libraries();
  ::signal(SIGXFSZ, SIG_IGN);  // A file that grows too large is then a failed write, with its line.
  std::stop_source source;
  stop_on_signals(source);
  try {
    const StudioJob job;
    return run_verb(arguments, source.get_token());
  } catch (const Canceled&) {
    return report_interruption();
  } catch (...) {
    if (source.stop_requested()) return report_interruption();  // Errors after an interruption may have any form.
    const app::Failure failure = app::current_failure();
    print_error(failure.message);
    return failure.code;
  }
}

}  // namespace
}  // namespace patinate::cli

int main(int argc, char** argv) { return patinate::cli::guarded_main({argv + 1, argv + argc}); }
