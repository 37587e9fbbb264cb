/// \file
/// Long work as a plan of items: plan -> run each -> join. What is finished is never redone, and the output is whole or
/// absent.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Outputs of an item below this folder serve later items and resumed runs only; they are not in the finished output.
inline constexpr const char* kJobWorkFolder = ".job/work";

/// One piece of work, independent of the others.
struct JobItem {
  std::string name;  ///< Unique in the plan; [A-Za-z0-9._-].
  std::vector<std::filesystem::path>
      outputs;  ///< Files it makes, relative to the output folder; each must be there afterwards.
  std::function<void(const std::filesystem::path& folder, const RunControl& control)> run;
  /// Content key of all that the outputs depend on: a finished item stays when the rest of the plan changes. "" = the
  /// plan's.
  std::string key = "";
  /// Items of a stage run when all of the earlier stages are finished, and may read what those wrote.
  int stage = 0;
  /// Its share of the progress, against the other items': about the time that it takes, in any unit. > 0.
  double weight = 1.0;
  /// Files that it makes where there is something to write. What it writes is declared in one of the two lists, or the
  /// job fails: a resumed run removes what nobody declares.
  std::vector<std::filesystem::path> optional_outputs = {};
  std::vector<std::string> inputs = {};  ///< Names of JobPlan::depends_on that it reads; empty: it may read any.
};

/// One thing that a plan's key depends on, for saying why work is done again.
struct JobDependency {
  std::string name;  ///< Name as a user would say it: "photos/day07.jpg", "--spatial-sigma", "capture.json".
  std::string key;   ///< Content key, or the value itself when it is short.
};

struct JobPlan {
  std::filesystem::path output;                ///< The folder to make.
  std::string manifest;                        ///< File in it that holds `"key"`, e.g. "history.json".
  std::string key;                             ///< Content key of inputs, parameters and stage versions.
  std::vector<JobDependency> depends_on = {};  ///< Inputs of `key`; may be empty.
  std::vector<JobItem> items;                  ///< Run by stage, in order; `parallel_items` at a time.
  /// The finished folder may be replaced without `force` when everything that it was made from is still there and
  /// unchanged, and something was added (a photograph at the end of a sequence). Needs `depends_on` to be complete.
  bool may_grow = false;
  bool parallel_items = true;  ///< false: one after another (each uses all threads itself).
  /// Files below kJobWorkFolder that items replace in turn, each time by a whole one: a resumed run of the same plan
  /// finds the last.
  std::vector<std::filesystem::path> shared_work = {};
  /// Called last, after every item, with the folder: writes the manifest (with the key).
  std::function<void(const std::filesystem::path& folder, const RunControl& control)> join;
  double join_weight = 1.0;     ///< Join weight of `join`, as JobItem::weight.
  double weight_seconds = 0.0;  ///< Core seconds that a weight of 1 takes; 0 = not known.
};

enum class JobStatus { Done, UpToDate };

struct JobOptions {
  /// Make the output again, in place of a different one or of the same (the folders are exchanged atomically).
  bool force = false;
  bool keeps_same = false;  ///< `force` replaces a different output only: others may have made this one just now.
  /// Called with the folder when all is made, before it becomes OUT: for write_run_record(). May be empty.
  std::function<void(const std::filesystem::path& folder)> add_record = {};
  /// Called before the first item runs, when an interrupted run or the output that is replaced has finished some: how
  /// many of how many, and the last of them.
  std::function<void(std::size_t num_done, std::size_t num_items, const std::string& last)> on_resume = {};
};

/// @throws InvalidInput if an item's name is no file name or not unique, an output lies outside the folder, or shared
/// work outside its folder.
void check_plan(const JobPlan& plan);

/// Works in `OUT.partial` (locked, its key inside), marks finished items there, and renames it to OUT at the end.
/// However a run ends, the next resumes with the finished items whose key is still the same; others are discarded.
/// Where OUT is replaced, its items that have keys of their own and are still planned are taken over (hard links), when
/// their files are unchanged since. OUT also gets `job.json` (job_record.h).
/// An OUT of which files were lost is made again, with what is left of it.
/// @throws CannotComplete if OUT exists with another key, may not grow and not `force`; if a file of it has another
/// size than it was made with and not `force`; if another process holds the lock, if it cannot be written, or if an
/// item lacks an output or wrote what no item declares; Canceled.
JobStatus run_job(const JobPlan& plan, const JobOptions& options, const RunControl& control);

/// A file that is an output, or one of several that are made together.
struct OutputFile {
  std::filesystem::path path;
  std::string existing_key = "";  ///< That it carries; "" if it is missing, damaged or none of ours.
  bool is_folder = false;         ///< Such as the textures of a model.
  bool lacks_files = false;       ///< A folder that lacks files is made again, as what is missing.
};

/// Outputs that are no job's folder: decides by the keys that the files carry, before anything is written. Every file
/// that is going to be written has to be among them.
/// @returns UpToDate if all carry `key`, and not `force`. @throws CannotComplete if one exists with another key and not
/// `force`, or is of another type.
JobStatus check_output_files(const std::vector<OutputFile>& files, const std::string& key, const JobOptions& options);
/// Checks one file.
JobStatus check_output_file(const std::filesystem::path& output, const std::string& existing_key,
                            const std::string& key, const JobOptions& options);

/// Writes `run.json` beside a manifest: date, command line, host, seconds, and the options in force. Never part of a
/// key.
void write_run_record(const std::filesystem::path& folder, const std::vector<std::string>& command_line, double seconds,
                      const Json& options);

}  // namespace patinate
