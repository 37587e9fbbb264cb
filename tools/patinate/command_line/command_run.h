/// \file
/// One run of a command: its arguments, progress, canceling and its result.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "libcommon/job/job.h"
#include "libcommon/job/job_report.h"
#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "tools/patinate/command_line/command_line.h"
#include "tools/patinate/command_line/plan_request.h"

namespace patinate::cli {

class ProgressLine;

/// A command declares its arguments on `line`, calls parse(), works with control(), and ends with one of the reports.
class CommandRun {
 public:
  /// @param arguments  What follows the verb.
  CommandRun(std::string verb, std::string brief, std::vector<std::string> arguments, std::stop_token stop);
  ~CommandRun();

  CommandLine line;

  /// The first word that is no option, "" if the arguments begin with one: for commands whose options depend on it.
  [[nodiscard]] std::string first_positional() const;
  /// Arguments as given, without the verb.
  [[nodiscard]] const std::vector<std::string>& arguments() const { return arguments_; }
  [[nodiscard]] std::stop_token stop() const { return stop_; }
  /// The command is asked for its work as a plan, or for a part of it. @param request  Must outlive the run.
  void answer(PlanRequest& request) { request_ = &request; }
  [[nodiscard]] PlanRequest* request() const { return request_; }
  /// Makes parse() return false: the command then has only declared its arguments on `line`.
  void only_declare() { is_only_declared_ = true; }
  /// Only declares, and reports arguments that do not go together.
  void only_check() { is_only_declared_ = is_checked_ = true; }
  [[nodiscard]] bool is_only_declared() const { return is_only_declared_; }
  /// Options come from the command line, else the environment, else the file of --config.
  /// @returns false when --help was printed: the command then returns at once.
  [[nodiscard]] bool parse();
  /// Whom the inputs' histories owe (credits_of()): for run.json, and for files that can say it.
  [[nodiscard]] std::vector<std::string> credits() const;
  /// Progress under a label of one or two words, the stop token, --threads.
  [[nodiscard]] RunControl control(const std::string& label);
  /// Planned work may be made by several at a time: `force` then means other outputs only.
  [[nodiscard]] JobOptions job_options() const {
    return {.force = line.common().force, .keeps_same = request_ != nullptr};
  }
  /// Seconds since the command began.
  [[nodiscard]] double seconds() const;
  /// "patinate", the verb and its arguments, for run.json.
  [[nodiscard]] std::vector<std::string> command_line() const;

  /// Makes the folder of a plan, with its run.json. With --dry-run says what would be done instead; where items of the
  /// plan are asked for (answer()), runs those.
  /// @returns nothing unless the folder is there in the end: the command then returns 0.
  [[nodiscard]] std::optional<JobStatus> make_folder(const JobPlan& plan, const std::string& label);
  /// Whether an output is to be made that is no folder; as check_output_files(). With --dry-run says what would be done
  /// instead. To a plan all of it is one item.
  /// @param files  The output, and all that is written with it. Not empty.
  /// @returns nothing after a dry run or when only the plan is asked for: the command then returns 0.
  /// @throws UsageError if a file is an input.
  [[nodiscard]] std::optional<JobStatus> check_files(const std::vector<OutputFile>& files, const std::string& key);
  /// Checks one file.
  [[nodiscard]] std::optional<JobStatus> check_file(const std::filesystem::path& output,
                                                    const std::string& existing_key, const std::string& key);

  /// A line on stderr, unless --quiet.
  void note(const std::string& text);
  /// Says that a result may be wrong: "warning: " stands before it.
  void warn(const std::string& text) { note("warning: " + text); }
  /// The first 20 of them, and how many more there are.
  void notes(const std::vector<std::string>& texts);
  /// In the end, since an error is one line: what was given in a form that has another one now.
  void note_advice() { notes(line.advice()); }
  /// A line on stderr with --verbose.
  void detail(const std::string& text);
  /// Problems of an input, one line each on stderr as errors are: the first 20, and how many more there are.
  void note_problems(const std::vector<std::string>& problems);
  /// The end of a command that makes `output`: a line on stderr, or with --json an object with `output`, `status` and
  /// the members of `more` on stdout.
  void report_output(JobStatus status, const std::filesystem::path& output);
  void report_output(JobStatus status, const std::filesystem::path& output, const Json& more);
  /// The end of a dry run: what the command would do, and why.
  void report_dry_run(const JobReport& job);
  /// The end of a command that tells something: `text` or, with --json, `json`, on stdout.
  void report(const Json& json, const std::string& text);
  /// Text on stdout as it is. @throws CannotComplete if it cannot be written.
  void print(const std::string& text);

  /// The end of a run of some items: how many were run, of those that were asked for.
  void report_items(const std::filesystem::path& output, std::size_t num_run, std::size_t num_asked);

 private:
  void supply_options();
  std::optional<JobStatus> answer_folder(const JobPlan& plan, const JobOptions& options, const std::string& label);
  std::optional<JobStatus> answer_files(const std::vector<OutputFile>& files, const std::string& key);
  /// With --verbose says how long the part of the work took that the last control() began.
  void end_stage();

  std::string verb_;
  std::vector<std::string> arguments_;
  std::stop_token stop_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  bool is_only_declared_ = false, is_checked_ = false;
  PlanRequest* request_ = nullptr;
  std::shared_ptr<ProgressLine> progress_;
  std::vector<std::string> unknown_variables_;
  std::string stage_;  ///< Label of the part of the work that continues; "" = none.
  double stage_begin_ = 0.0;
};

}  // namespace patinate::cli
