#include "tools/patinate/command_line/command_run.h"

#include <sys/resource.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/printable.h"
#include "libcommon/job/partial_folder.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/message_stream.h"
#include "tools/patinate/command_line/option_sources.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/progress_line.h"
#include "tools/patinate/command_line/verbs.h"

namespace patinate::cli {

namespace {

std::string peak_memory_text() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return std::to_string((usage.ru_maxrss + 1023) / 1024) + " MB";
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

}  // namespace

CommandRun::CommandRun(std::string verb, std::string brief, std::vector<std::string> arguments, std::stop_token stop)
    : line(verb, std::move(brief)), verb_(std::move(verb)), arguments_(std::move(arguments)), stop_(std::move(stop)) {}
CommandRun::~CommandRun() = default;

std::string CommandRun::first_positional() const {
  return arguments_.empty() || arguments_.front().starts_with("-") ? "" : arguments_.front();
}

bool CommandRun::parse() {
  if (is_only_declared_) return false;
  if (line.parse(arguments_, [this] { supply_options(); })) {
    for (const std::string& variable : unknown_variables_) detail(variable);
    return true;
  }
  print(line.help());
  return false;
}

void CommandRun::supply_options() {
  const Environment environment = patinate_environment();
  if (environment.empty() && line.config().empty()) return;
  const std::vector<CommandDeclaration> commands = all_declarations();
  unknown_variables_ = supply_environment(line, environment, commands);
  if (!line.config().empty()) supply_config(line, verb_, line.config(), commands);
}

void CommandRun::print(const std::string& text) { print_result(text); }

RunControl CommandRun::control(const std::string& label) {
  end_stage();
  stage_ = label;
  stage_begin_ = seconds();
  RunControl control;
  control.stop = stop_;
  control.num_threads = line.common().threads;
  if (!line.common().quiet) {
    progress_ = std::make_shared<ProgressLine>(label);
    // A note or the next label ends the line, which work under this one may outlive.
    control.on_progress = [line_shown = std::weak_ptr(progress_)](double f) {
      if (const auto p = line_shown.lock()) p->show(f);
    };
  }
  return control;
}

double CommandRun::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

std::vector<std::string> CommandRun::command_line() const {
  std::vector<std::string> words{"patinate", verb_};
  words.insert(words.end(), arguments_.begin(), arguments_.end());
  return words;
}

std::optional<JobStatus> CommandRun::make_folder(const JobPlan& plan, const std::string& label) {
  require_no_file_name(plan.output);
  if (line.common().dry_run) {
    report_dry_run(explain_job(plan, job_options()));
    return std::nullopt;
  }
  JobOptions options = job_options();
  options.add_record = [this](const std::filesystem::path& folder) {
    write_run_record(folder, command_line(), seconds(), line.effective_options());
  };
  const RunControl stage = control(label);
  std::string continued;
  options.on_resume = [&](std::size_t num_done, std::size_t num_items, const std::string& last) {
    continued = "continued: " + std::to_string(num_done) + " of " + std::to_string(num_items) +
                " steps were done before, " + last + " the last of them";
  };
  const JobStatus status = run_job(plan, options, stage);
  if (!continued.empty()) note(continued);  // Not before: an error is one line.
  return status;
}

std::optional<JobStatus> CommandRun::check_file(const std::filesystem::path& output, const std::string& existing_key,
                                                const std::string& key) {
  if (!line.common().dry_run) return check_output_file(output, existing_key, key, job_options());
  report_dry_run(explain_output_file(output, existing_key, key, job_options()));
  return std::nullopt;
}

void CommandRun::end_stage() {
  if (stage_.empty()) return;
  const std::string stage = std::exchange(stage_, "");
  detail(stage + ": " + seconds_text(seconds() - stage_begin_));
}

void CommandRun::note(const std::string& text) {
  progress_.reset();
  if (!line.common().quiet) print_note(text);
}

void CommandRun::detail(const std::string& text) {
  if (line.common().verbose) note(text);
}

void CommandRun::note_problems(const std::vector<std::string>& problems) {
  progress_.reset();
  for (const std::string& problem : problems) print_error(problem);
}

void CommandRun::report_output(JobStatus status, const std::filesystem::path& output) {
  report_output(status, output, Json::object());
}

void CommandRun::report_output(JobStatus status, const std::filesystem::path& output, const Json& more) {
  const bool is_done = status == JobStatus::Done;
  end_stage();
  detail("memory: " + peak_memory_text() + " at most");
  note(output.string() + ": " + (is_done ? "done in " + seconds_text(seconds()) : "up to date"));
  if (!line.common().json) return;
  Json result{{"output", output.string()}, {"status", is_done ? "done" : "up to date"}};
  result.update(more);
  print(result.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void CommandRun::report_dry_run(const JobReport& job) { report(job.json(), job.text()); }

void CommandRun::report(const Json& json, const std::string& text) {
  progress_.reset();
  print((line.common().json ? json.dump(2, ' ', false, Json::error_handler_t::replace) : printable_lines(text)) + "\n");
}

}  // namespace patinate::cli
