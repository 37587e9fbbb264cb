/// \file
/// Jobs: commands that run as processes of their own, some at a time and the others one after the other. They end with
/// the studio.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tools/studio/job_commands.h"

namespace patinate::studio {

struct JobLimits {
  int num_running = 2;
  int num_waiting = 20;
  int num_ended = 50;                                 ///< That are still listed.
  std::uint64_t max_bytes = std::uint64_t{20} << 30;  ///< Of all that a job has made.
  std::uint64_t least_free = std::uint64_t{1} << 30;  ///< Bytes that stay free on the disk.
  std::chrono::seconds max_time{std::chrono::hours{24}};
  std::chrono::milliseconds patience{5000};  ///< From the wish that a job ends until it is ended.
};

/// What runs, and how.
struct JobProgram {
  std::filesystem::path file;
  std::vector<std::string> environment;  ///< "NAME=VALUE", all of it.
  JobLimits limits = {};
};

enum class JobState { Waiting, Running, Done, Failed, Canceled };
inline constexpr std::array<std::string_view, 5> kJobStateNames{"waiting", "running", "done", "failed", "canceled"};

struct JobStatusReport {
  int id = 0;
  JobRequest request;
  JobState state = JobState::Waiting;
  std::string stage;            ///< "transfer"; "" before it is known.
  std::optional<double> share;  ///< Of the stage.
  std::string left;             ///< "0:12", of the stage; "" while it is not known.
  std::vector<std::string> messages;
  double seconds = 0.0;
  std::optional<int> exit_code;
};

/// Thread-safe.
class JobRunner {
 public:
  /// @param folder  Where jobs run.
  JobRunner(std::filesystem::path folder, JobProgram program);
  ~JobRunner();
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;

  /// @returns the job's number. @throws InvalidInput if too many wait, or another one makes the same output.
  int start(JobRequest request);
  /// The newest first.
  [[nodiscard]] std::vector<JobStatusReport> list() const;
  [[nodiscard]] std::optional<JobStatusReport> find(int id) const;
  /// Asks it to end, as Ctrl-C does: what it has finished stays, and the same command resumes it. @returns false if
  /// there is no such job.
  bool cancel(int id);

 private:
  struct Job;
  void run(const std::stop_token& stop);
  void begin(Job& job);
  void look_after(Job& job);
  void limit(Job& job);
  void end(Job& job, int status);
  void ask_to_end(Job& job, const std::string& why);
  void start_waiting();
  void forget_old();
  [[nodiscard]] static JobStatusReport report(const Job& job);

  std::filesystem::path folder_;
  JobProgram program_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::unique_ptr<Job>> jobs_;  ///< In the order in which they came.
  int next_id_ = 1;
  std::jthread thread_;
};

}  // namespace patinate::studio
