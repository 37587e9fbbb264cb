#include "tools/studio/job_runner.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "libcommon/core/text.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxMessages = 40, kMaxLine = 2000;
constexpr std::chrono::milliseconds kLook{100};  ///< How often a running job is looked at.
constexpr std::chrono::seconds kMeasure{2};      ///< How often what it has made is measured.

/// "transfer: 37 %, 0:12 left", as ProgressLine writes it.
struct ProgressText {
  std::string stage;
  double share = 0.0;
  std::string left;
};

std::optional<ProgressText> progress_of(const std::string& line) {
  const std::size_t percent = line.rfind(" %"), colon = line.substr(0, percent).rfind(": ");
  if (percent == std::string::npos || colon == std::string::npos) return std::nullopt;
  const std::optional<double> number = parse_number(line.substr(colon + 2, percent - colon - 2));
  constexpr std::string_view kComma = ", ", kLeft = " left";
  std::string rest = line.substr(percent + 2);
  if (!number || !(*number >= 0.0 && *number <= 100.0)) return std::nullopt;
  if (!rest.empty() && !(rest.starts_with(kComma) && rest.ends_with(kLeft))) return std::nullopt;
  if (!rest.empty()) rest = rest.substr(kComma.size(), rest.size() - kComma.size() - kLeft.size());
  return ProgressText{line.substr(0, colon), *number / 100.0, rest};
}

/// Links are not followed.
std::uint64_t bytes_below(const fs::path& path) {
  std::error_code error;
  if (fs::is_symlink(path, error)) return 0;
  if (fs::is_regular_file(path, error)) return fs::file_size(path, error);
  std::uint64_t sum = 0;
  for (fs::recursive_directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (!it->is_symlink(ignored) && it->is_regular_file(ignored)) sum += it->file_size(ignored);
  }
  return sum;
}

std::string gigabytes(std::uint64_t bytes) {
  return short_number_text(rounded(static_cast<double>(bytes) / 1e9, 2)) + " GB";
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

struct JobRunner::Job {
  int id = 0;
  JobRequest request;
  JobState state = JobState::Waiting;
  pid_t pid = -1;
  int messages_fd = -1;
  std::string rest;  ///< Of a line that has not ended.
  std::deque<std::string> messages;
  std::optional<ProgressText> progress;
  std::optional<int> exit_code;
  Clock::time_point began, ended, measured;
  std::optional<Clock::time_point> asked_to_end;
  bool is_canceled = false, is_killed = false;

  void say(const std::string& line) {
    if (line.empty()) return;
    if (auto read = progress_of(line)) {
      progress = std::move(read);
      return;
    }
    messages.push_back(line.substr(0, kMaxLine));
    if (messages.size() > kMaxMessages) messages.pop_front();
  }

  void hear() {
    std::array<char, 4096> bytes{};
    for (ssize_t n = 0; (n = ::read(messages_fd, bytes.data(), bytes.size())) > 0;) {
      rest.append(bytes.data(), static_cast<std::size_t>(n));
      for (std::size_t at = 0; (at = rest.find('\n')) != std::string::npos; rest.erase(0, at + 1))
        say(rest.substr(0, at));
      if (rest.size() > kMaxLine) rest.resize(kMaxLine);
    }
  }
};

JobRunner::JobRunner(fs::path folder, JobProgram program) : folder_(std::move(folder)), program_(std::move(program)) {
  if (!program_.file.empty()) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

JobRunner::~JobRunner() = default;  // The thread ends first, and with it all jobs.

int JobRunner::start(JobRequest request) {
  const std::lock_guard lock(mutex_);
  if (program_.file.empty()) throw InvalidInput("no jobs are run here");
  const auto is_open = [](const auto& job) { return job->state <= JobState::Running; };
  const auto is_waiting = [](const auto& job) { return job->state == JobState::Waiting; };
  if (std::count_if(jobs_.begin(), jobs_.end(), is_waiting) >= program_.limits.num_waiting)
    throw InvalidInput(std::to_string(program_.limits.num_waiting) +
                       " jobs wait already; wait for some, or cancel them");
  const fs::path output = fs::path(request.output).lexically_normal();
  if (std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& job) {
        return is_open(job) && fs::path(job->request.output).lexically_normal() == output;
      }))
    throw WrongArgument("output", "another job makes this; give another name");
  auto job = std::make_unique<Job>();
  job->id = next_id_++;
  job->request = std::move(request);
  job->began = job->ended = Clock::now();
  jobs_.push_back(std::move(job));
  changed_.notify_all();
  return jobs_.back()->id;
}

JobStatusReport JobRunner::report(const Job& job) {
  const Clock::time_point end = job.state == JobState::Running ? Clock::now() : job.ended;
  JobStatusReport out{.id = job.id,
                      .request = job.request,
                      .state = job.state,
                      .stage = {},
                      .share = {},
                      .left = {},
                      .messages = {job.messages.begin(), job.messages.end()},
                      .seconds = std::chrono::duration<double>(end - job.began).count(),
                      .exit_code = job.exit_code};
  if (job.progress) {
    out.stage = job.progress->stage;
    out.share = job.progress->share;
    out.left = job.progress->left;
  }
  return out;
}

std::vector<JobStatusReport> JobRunner::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<JobStatusReport> all;
  for (auto it = jobs_.rbegin(); it != jobs_.rend(); ++it) all.push_back(report(**it));
  return all;
}

std::optional<JobStatusReport> JobRunner::find(int id) const {
  const std::lock_guard lock(mutex_);
  for (const auto& job : jobs_) {
    if (job->id == id) return report(*job);
  }
  return std::nullopt;
}

bool JobRunner::cancel(int id) {
  const std::lock_guard lock(mutex_);
  for (const auto& job : jobs_) {
    if (job->id != id) continue;
    if (job->state == JobState::Waiting) job->state = JobState::Canceled;
    if (job->state == JobState::Running) {
      job->is_canceled = true;
      ask_to_end(*job, "");
    }
    return true;
  }
  return false;
}

/// All processes are begun and ended by one thread, since a process may end with the thread that began it.
void JobRunner::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const auto num_running = [&] {
    return std::count_if(jobs_.begin(), jobs_.end(), [](const auto& job) { return job->state == JobState::Running; });
  };
  while (!stop.stop_requested()) {
    start_waiting();
    for (const auto& job : jobs_) {
      if (job->state == JobState::Running) look_after(*job);
    }
    forget_old();
    if (num_running() > 0)
      changed_.wait_for(lock, stop, kLook, [] { return false; });
    else
      changed_.wait(lock, stop, [&] {
        return std::any_of(jobs_.begin(), jobs_.end(), [](const auto& job) { return job->state == JobState::Waiting; });
      });
  }
  for (const auto& job : jobs_) {
    if (job->state == JobState::Running) ask_to_end(*job, "the studio has ended");
  }
  while (num_running() > 0) {
    for (const auto& job : jobs_) {
      if (job->state == JobState::Running) look_after(*job);
    }
    changed_.wait_for(lock, kLook / 4, [] { return false; });
  }
}

void JobRunner::start_waiting() {
  auto num_running =
      std::count_if(jobs_.begin(), jobs_.end(), [](const auto& job) { return job->state == JobState::Running; });
  for (const auto& job : jobs_) {
    if (num_running >= program_.limits.num_running) return;
    if (job->state != JobState::Waiting) continue;
    begin(*job);
    num_running += job->state == JobState::Running;
  }
}

void JobRunner::begin(Job& job) {
  job.began = job.ended = job.measured = Clock::now();
  const auto fail = [&](const std::string& why) {
    job.say(why);
    job.state = JobState::Failed;
  };
  std::error_code error;
  if (fs::symlink_status(folder_ / job.request.output, error).type() != fs::file_type::not_found)
    return fail(job.request.output + ": exists by now; give another name");
  if (fs::space(folder_, error).available < program_.limits.least_free)
    return fail("less than " + gigabytes(program_.limits.least_free) + " are free on the disk; make room first");
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0)
    return fail(std::string("cannot be started; ") + std::strerror(errno));
  ::fcntl(ends[1], F_SETFL, 0);  // The job waits until it has been heard.
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);  // The server's sockets.
  posix_spawn_file_actions_addchdir_np(&actions, folder_.c_str());
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);  // What it starts is ended with it.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::vector<std::string> words{"patinate"}, environment = program_.environment;
  words.insert(words.end(), job.request.words.begin(), job.request.words.end());
  const int failure = ::posix_spawn(&job.pid, program_.file.c_str(), &actions, &attributes, pointers_to(words).data(),
                                    pointers_to(environment).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  job.messages_fd = ends[0];
  if (failure != 0) {
    ::close(std::exchange(job.messages_fd, -1));
    return fail(std::string("cannot be started; ") + std::strerror(failure));
  }
  const rlimit longest_file{program_.limits.max_bytes, program_.limits.max_bytes};
  ::prlimit(job.pid, RLIMIT_FSIZE, &longest_file, nullptr);
  job.state = JobState::Running;
}

void JobRunner::look_after(Job& job) {
  job.hear();
  int status = 0;
  if (::waitpid(job.pid, &status, WNOHANG) == job.pid) return end(job, status);
  limit(job);
  if (job.asked_to_end && !job.is_killed && Clock::now() - *job.asked_to_end > program_.limits.patience) {
    ::kill(-job.pid, SIGKILL);
    job.is_killed = true;
  }
}

void JobRunner::limit(Job& job) {
  const JobLimits& limits = program_.limits;
  const Clock::time_point now = Clock::now();
  if (job.asked_to_end) return;
  if (now - job.began > limits.max_time)
    return ask_to_end(
        job, "was ended: a job may take " +
                 short_number_text(std::chrono::duration<double, std::ratio<3600>>(limits.max_time).count()) + " h");
  if (now - job.measured < std::min<Clock::duration>(kMeasure, limits.max_time)) return;
  job.measured = now;
  std::uint64_t bytes = 0;
  for (const char* more : {"", ".partial", ".items"})
    bytes += bytes_below((folder_ / job.request.output).string() + more);
  std::error_code error;
  if (bytes > limits.max_bytes)
    ask_to_end(job, "was ended: a job may make " + gigabytes(limits.max_bytes));
  else if (fs::space(folder_, error).available < limits.least_free)
    ask_to_end(job, "was ended: less than " + gigabytes(limits.least_free) + " are free on the disk");
}

void JobRunner::ask_to_end(Job& job, const std::string& why) {
  if (job.asked_to_end) return;
  job.say(why);
  job.asked_to_end = Clock::now();
  ::kill(-job.pid, SIGINT);
}

void JobRunner::end(Job& job, int status) {
  job.hear();
  job.say(std::exchange(job.rest, ""));
  ::kill(-job.pid, SIGKILL);  // What it has left behind.
  ::close(std::exchange(job.messages_fd, -1));
  job.pid = -1;
  job.ended = Clock::now();
  if (WIFEXITED(status)) job.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status) && !job.asked_to_end) job.say(std::string("has crashed: ") + ::strsignal(WTERMSIG(status)));
  std::error_code error;
  // An output is whole or not there: a grading that says "not passed" is done, too.
  const bool is_made = fs::exists(folder_ / job.request.output, error);
  job.state = is_made ? JobState::Done : job.is_canceled ? JobState::Canceled : JobState::Failed;
}

void JobRunner::forget_old() {
  auto num_ended =
      std::count_if(jobs_.begin(), jobs_.end(), [](const auto& job) { return job->state > JobState::Running; });
  std::erase_if(jobs_, [&](const auto& job) {
    return job->state > JobState::Running && num_ended-- > program_.limits.num_ended;
  });
}

}  // namespace patinate::studio
