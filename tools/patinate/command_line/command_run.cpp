#include "tools/patinate/command_line/command_run.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/request/output_file.h"
#include "app/request/usage_error.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/printable.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_card.h"
#include "libcommon/job/spread_job.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/message_stream.h"
#include "tools/patinate/command_line/option_sources.h"
#include "tools/patinate/command_line/progress_line.h"
#include "tools/patinate/command_line/verbs.h"

namespace patinate::cli {

namespace {

constexpr std::size_t kMaxLines = 20;  ///< Most lines of notes or problems at once; nobody reads more.

long peak_megabytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return (usage.ru_maxrss + 1023) / 1024;
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
  if (is_only_declared_) {
    // With all of its arguments it says what is wrong with them: check_options(), check_arguments().
    const bool is_given = std::find(arguments_.begin(), arguments_.end(), "-o") != arguments_.end();
    if (is_given && line.parse(arguments_) && is_checked_) line.check();
    return false;
  }
  if (line.parse(arguments_, [this] { supply_options(); })) {
    line.check();
    for (const std::string& variable : unknown_variables_) detail(variable);
    // Predictions are printed as ever.
    const bool is_whole = request_ != nullptr && request_->wanted == PlanRequest::Wanted::Whole;
    if (is_whole && line.common().dry_run) request_ = nullptr;
    return true;
  }
  std::vector<std::pair<std::string, std::string>> below;
  for (const Verb& verb : verbs()) {
    if (is_below(verb, verb_)) below.emplace_back(verb.name, verb.brief);
  }
  if (!below.empty()) line.list("Commands of their own", below);
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
  std::vector<std::string> words = split("patinate " + verb_, ' ');
  words.insert(words.end(), arguments_.begin(), arguments_.end());
  return words;
}

std::vector<std::string> CommandRun::credits() const {
  std::vector<std::string> all;
  for (const std::filesystem::path& input : line.inputs()) {
    for (const std::string& credit : credits_of(input)) {
      if (std::find(all.begin(), all.end(), credit) == all.end()) all.push_back(credit);
    }
  }
  return all;
}

std::optional<JobStatus> CommandRun::make_folder(const JobPlan& plan, const std::string& label) {
  app::require_no_file_name(plan.output);
  if (line.common().dry_run && request_ == nullptr) {
    report_dry_run(explain_job(plan, job_options()));
    return std::nullopt;
  }
  JobOptions options = job_options();
  options.add_record = [this](const std::filesystem::path& folder) {
    write_run_record(folder, command_line(), seconds(), line.effective_options());
    add_credits(folder, credits());
  };
  if (request_ != nullptr) return answer_folder(plan, options, label);
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

std::optional<JobStatus> CommandRun::check_files(const std::vector<OutputFile>& files, const std::string& key) {
  for (const OutputFile& file : files) {
    line.require_apart(&file == &files.front() ? "-o" : "beside -o", file.path);
    if (is_noted_input(file.path))
      throw app::UsageError(file.path.string() + ": is an input and would be replaced; expected another output");
  }
  if (request_ != nullptr) return answer_files(files, key);
  if (!line.common().dry_run) return check_output_files(files, key, job_options());
  report_dry_run(explain_output_files(files, key, job_options()));
  return std::nullopt;
}

std::optional<JobStatus> CommandRun::check_file(const std::filesystem::path& output, const std::string& existing_key,
                                                const std::string& key) {
  return check_files({{.path = output, .existing_key = existing_key}}, key);
}

std::optional<JobStatus> CommandRun::answer_folder(const JobPlan& unordered, const JobOptions& options,
                                                   const std::string& label) {
  JobPlan plan = unordered;  // Numbered in the order in which they can be run.
  std::stable_sort(plan.items.begin(), plan.items.end(),
                   [](const JobItem& a, const JobItem& b) { return a.stage < b.stage; });
  using Wanted = PlanRequest::Wanted;
  if (request_->identity) require_same_work(*request_->identity, plan.key, plan.depends_on);
  if (request_->wanted == Wanted::Description) {
    request_->work = planned_work(plan);
    return std::nullopt;
  }
  const RunControl stage = control(label);
  if (request_->wanted == Wanted::Join) return join_spread_items(plan, options, stage);
  const std::vector<std::size_t> items = asked_items(*request_, plan.items.size());
  const bool is_whole = request_->wanted == Wanted::Whole;
  const double share = is_whole ? plan.items.empty() ? 0.0 : 0.9 : 1.0;
  const std::size_t num_run = run_spread_items(plan, items, options, stage.part(0.0, share));
  if (is_whole) return join_spread_items(plan, options, stage.part(share, 1.0));
  report_items(plan.output, num_run, items.size());
  return std::nullopt;
}

std::optional<JobStatus> CommandRun::answer_files(const std::vector<OutputFile>& files, const std::string& key) {
  using Wanted = PlanRequest::Wanted;
  if (request_->identity) require_same_work(*request_->identity, key, {});
  const bool is_made =
      std::all_of(files.begin(), files.end(), [&](const OutputFile& file) { return file.existing_key == key; });
  std::vector<std::filesystem::path> outputs;
  for (const OutputFile& file : files) outputs.push_back(file.path);
  const PlannedWork work{
      .output = outputs.front(),
      .key = key,
      .depends_on = {},
      .items = {{.name = "file", .key = key, .outputs = outputs, .waits_for = {}, .is_finished = is_made}},
      .is_up_to_date = is_made};
  if (request_->wanted == Wanted::Description) {
    (void)check_output_files(files, key, job_options());  // Says what is in the way.
    request_->work = work;
    return std::nullopt;
  }
  if (request_->wanted == Wanted::Items) (void)asked_items(*request_, 1);
  if (request_->wanted == Wanted::Join) require_finished(work);
  return check_output_files(files, key, job_options());
}

void CommandRun::report_items(const std::filesystem::path& output, std::size_t num_run, std::size_t num_asked) {
  end_stage();
  const std::size_t num_before = num_asked - num_run;
  note(output.string() + ": " + std::to_string(num_run) + (num_run == 1 ? " item" : " items") + " done in " +
       seconds_text(seconds()) + (num_before == 0 ? "" : "; " + std::to_string(num_before) + " finished before"));
  if (line.common().json)
    print(printable_json(Json{{"output", output.string()},
                              {"run", num_run},
                              {"finished_before", num_before},
                              {"seconds", rounded(seconds(), 3)},
                              {"megabytes", peak_megabytes()}}) +
          "\n");
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

void CommandRun::notes(const std::vector<std::string>& texts) {
  for (std::size_t i = 0; i < std::min(kMaxLines, texts.size()); ++i) note(texts[i]);
  if (texts.size() > kMaxLines) note("and " + std::to_string(texts.size() - kMaxLines) + " more notes");
}

void CommandRun::detail(const std::string& text) {
  if (line.common().verbose) note(text);
}

void CommandRun::note_problems(const std::vector<std::string>& problems) {
  progress_.reset();
  for (std::size_t i = 0; i < std::min(kMaxLines, problems.size()); ++i) print_error(problems[i]);
  if (problems.size() > kMaxLines)
    print_error("and " + std::to_string(problems.size() - kMaxLines) + " more problems; --json lists all");
}

void CommandRun::report_output(JobStatus status, const std::filesystem::path& output) {
  report_output(status, output, Json::object());
}

void CommandRun::report_output(JobStatus status, const std::filesystem::path& output, const Json& more) {
  const bool is_done = status == JobStatus::Done;
  end_stage();
  detail("memory: " + std::to_string(peak_megabytes()) + " MB at most");
  if (is_done) {
    for (const std::string& credit : credits()) note("credit: " + credit);
  }
  note(output.string() + ": " + (is_done ? "done in " + seconds_text(seconds()) : "up to date"));
  if (!line.common().json) return;
  Json result{{"output", output.string()}, {"status", is_done ? "done" : "up to date"}};
  result.update(more);
  print(printable_json(result) + "\n");
}

void CommandRun::report_dry_run(const JobReport& job) { report(job.json(), job.text()); }

void CommandRun::report(const Json& json, const std::string& text) {
  progress_.reset();
  print((line.common().json ? printable_json(json) : printable_lines(text)) + "\n");
}

}  // namespace patinate::cli
