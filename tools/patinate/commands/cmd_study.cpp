#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/request/output_file.h"
#include "app/request/usage_error.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/programs.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/message_stream.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

const std::vector<std::string> kKinds{"run", "export", "report"};

struct JobsOptions {
  int jobs = 0;
};
void describe(OptionVisitor& v, JobsOptions& o) {
  v.visit({"jobs", "Cells at a time; 0 = one a processor", "", between(0, 4096)}, o.jobs);
}

Json arguments_json(const Verb& verb) {
  Json arguments = Json::array();
  for (const ArgumentInfo& a : declaration_of(verb).arguments) {
    arguments.push_back({{"key", a.key()},
                         {"name", a.name},
                         {"is_option", !a.is_positional() && !a.is_common && a.name != "-o"},
                         {"is_flag", a.kind == ArgumentKind::Flag},
                         {"has_no_form", a.has_no_form},
                         {"is_path", a.type == ValueType::Path},
                         {"is_text", a.type == ValueType::Text}});
  }
  return arguments;
}

/// Answer of a command about its arguments, or about some words for them.
Json answer(const Json& question) {
  const std::vector<std::string> name = split(question.at("verb").get<std::string>(), ' ');
  const Verb& verb = *find_verb(name).value().verb;
  if (!question.contains("words")) return {{"arguments", arguments_json(verb)}};
  const auto words = question.at("words").get<std::vector<std::string>>();
  const Json& output = question.at("output");
  try {
    if (question.value("is_folder", false)) app::require_no_file_name(output.get<std::string>());
    if (output.is_null())
      check_options(verb, words);
    else
      check_arguments(verb, words, output.get<std::string>());
  } catch (const app::UsageError& e) {
    return {{"problem", e.what()}};
  } catch (const InputError& e) {
    return {{"error", e.what()}};
  }
  return Json::object();
}

/// Answers what the Python half asks while it reads a study: a question a line, and an answer a line.
int answer_questions() {
  for (std::string line; std::getline(std::cin, line);)
    print_result(answer(Json::parse(line)).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  return 0;
}

/// The folder of the Python module: of this build, installed, or in a virtual environment.
fs::path module_folder() {
  for (const char* folder : {"../python", PATINATE_PYTHON_FROM_PROGRAMS, PATINATE_ENVIRONMENT_FROM_PROGRAMS}) {
    const fs::path place = (programs_folder() / folder).lexically_normal();
    std::error_code error;
    for (fs::directory_iterator it(place / "patinate", error), end; !error && it != end; it.increment(error)) {
      if (it->path().filename().string().starts_with("_native.")) return place;
    }
  }
  throw CannotComplete(
      "study needs patinate's Python module, which is not there: install python3-patinate, or build all");
}

/// Goes on as the Python half, with `given`. @returns only by throwing.
[[noreturn]] void become_python(const Json& given) {
  const std::string place = module_folder().string(), text = given.dump();
  sigset_t signals;
  sigfillset(&signals);
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  ::dup2(::fileno(message_stream()), STDERR_FILENO);
  ::execlp(
      PATINATE_PYTHON_PROGRAM, "python3", "-c",
      "import sys; sys.path[0] = sys.argv[1]; from patinate._study.command import main; sys.exit(main(sys.argv[2]))",
      place.c_str(), text.c_str(), nullptr);
  throw CannotComplete(std::string(PATINATE_PYTHON_PROGRAM) + ": cannot be started; " + std::strerror(errno));
}

}  // namespace

int cmd_study(CommandRun& run) {
  std::string kind;
  fs::path study, output, snakemake;
  JobsOptions jobs;
  const std::string asked = run.first_positional();
  if (asked == "check") return answer_questions();
  run.line.positional("KIND", "run (here), export (for Snakemake) or report (of what was made, wherever)", kind);
  run.line.choices(kKinds);
  run.line.positional("STUDY", asked == "report" ? "The folder of a study" : "A study file (docs/study.md)", study);
  if (asked == "run") {
    run.line.output("FOLDER", "Folder of the study: cells/NAME, report.html, report.json, a CSV a part", output);
    run.line.options(jobs);
  }
  if (asked == "export") {
    run.line.option("snakemake", "FOLDER", "Folder of the study, with a Snakefile and its profiles", snakemake);
    run.line.required();
  }
  run.line.without({"seed", "force"});
  run.line.example("study run study.json -o copper_on_all");
  run.line.example("study export study.json --snakemake copper_on_all");
  run.line.example("study report copper_on_all");
  if (!run.parse()) return 0;
  const CommonOptions& common = run.line.common();
  become_python({{"kind", kind},
                 {"study", study.string()},
                 {"output", (kind == "export" ? snakemake : output).string()},
                 {"jobs", jobs.jobs},
                 {"threads", thread_count(run.control("study"))},
                 {"dry_run", common.dry_run},
                 {"json", common.json},
                 {"quiet", common.quiet},
                 {"program", fs::read_symlink("/proc/self/exe").string()}});
}

}  // namespace patinate::cli
