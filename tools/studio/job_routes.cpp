// Commands that a browser starts: /api/commands, /api/jobs.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/request/history_library.h"
#include "app/request/repeating_command.h"
#include "capture/project/found_images.h"
#include "libcommon/core/text.h"
#include "libcommon/image/decoder_process.h"
#include "libcommon/job/result_folder.h"
#include "patinate/history/history.h"
#include "tools/studio/jobs.h"
#include "tools/studio/outside_json.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

std::string line_of(const JobRequest& request) {
  std::string line = "patinate";
  for (const std::string& word : request.words) line += " " + app::shell_word(word);
  return line;
}

/// The place that a job has made; a project file stands for its folder.
std::optional<fs::path> place_of(const ServedFolder& folder, const std::string& output) {
  const std::optional<fs::path> made = folder.find(output);
  if (!made) return std::nullopt;
  for (const fs::path& path : {*made, made->parent_path()}) {
    if (place_kind(path) && (path == *made || made->filename() == "capture.json")) return path;
  }
  return std::nullopt;
}

Json job_json(const ServedFolder& folder, const JobStatusReport& job) {
  Json json{{"id", job.id},
            {"command", job.request.command},
            {"line", line_of(job.request)},
            {"output", job.request.output},
            {"arguments", Json::parse(job.request.arguments)},
            {"state", kJobStateNames[static_cast<std::size_t>(job.state)]},
            {"stage", job.stage},
            {"share", job.share ? Json(*job.share) : Json(nullptr)},
            {"left", job.left},
            {"messages", job.messages},
            {"seconds", rounded(job.seconds, 2)},
            {"exit_code", job.exit_code ? Json(*job.exit_code) : Json(nullptr)},
            {"place", nullptr},
            {"is_file", false}};
  if (job.state != JobState::Done) return json;
  std::error_code error;
  if (const std::optional<fs::path> place = place_of(folder, job.request.output))
    json["place"] = folder.name_of(*place);
  json["is_file"] = fs::is_regular_file(folder.path() / job.request.output, error);
  return json;
}

Json library_json() {
  Json all = Json::array();
  for (const app::LibraryEntry& entry : app::library_entries()) {
    Json controls = Json::array();
    try {
      for (const ControlParameter& c : read_history_manifest(entry.folder).controls) controls.push_back(c.name);
    } catch (const Error&) {
      continue;  // It is damaged: nothing can be made of it.
    }
    all.push_back({{"name", "library:" + entry.name}, {"controls", std::move(controls)}});
  }
  return all;
}

/// Folders with photographs that are no capture yet.
class PhotographFolders {
 public:
  explicit PhotographFolders(const ServedFolder& folder) : folder_(folder) { look(folder.path(), kDepth); }
  Json names = Json::array();

 private:
  static constexpr int kDepth = 5, kFewest = 2;

  void look(const fs::path& path, int depth) {
    int num_pictures = 0;
    bool has_movie = false;
    std::error_code error;
    std::vector<fs::path> inside;
    for (fs::directory_iterator it(path, error), end; !error && it != end && num_left_ > 0; it.increment(error)) {
      --num_left_;
      std::error_code ignored;
      const fs::path& child = it->path();
      if (child.filename().string().starts_with('.') || it->is_symlink(ignored)) continue;
      if (it->is_directory(ignored)) inside.push_back(child);
      num_pictures += capture::may_be_photograph(child) ? 1 : 0;
      has_movie = has_movie || is_movie(child);
    }
    std::sort(inside.begin(), inside.end());
    for (const fs::path& child : inside) {
      if (depth > 0 && !place_kind(child)) look(child, depth - 1);
    }
    // The served folder comes last: it may hold pictures that were rendered, too.
    const bool is_capture = fs::exists(path / "capture.json", error);
    if (!is_capture && (num_pictures >= kFewest || has_movie) && result_around(path).empty())
      names.push_back(folder_.name_of(path));
  }

  const ServedFolder& folder_;
  int num_left_ = 20'000;
};

}  // namespace

HttpResponse answer_commands(const Asked& asked) {
  return json_response(Json{{"folder", asked.folder.path().string()},
                            {"commands", asked.jobs.commands.json()},
                            {"library", library_json()},
                            {"photographs", PhotographFolders(asked.folder).names}});
}

HttpResponse answer_jobs(const Asked& asked) {
  Json all = Json::array();
  for (const JobStatusReport& job : asked.jobs.runner.list()) all.push_back(job_json(asked.folder, job));
  return json_response(Json{{"jobs", std::move(all)}});
}

HttpResponse start_job(const Asked& asked, const std::string& body) {
  const Json json = parse_outside_json(body);
  JsonReader reader("job", json);
  const bool is_check = reader.has("check") && reader.member("check").boolean();
  JobRequest request = asked.jobs.commands.read(asked.folder, reader);
  reader.finish();
  Json answer{{"line", line_of(request)}, {"output", request.output}};
  if (!is_check) answer["id"] = asked.jobs.runner.start(std::move(request));
  return json_response(answer);
}

HttpResponse cancel_job(const Asked& asked, const std::string& body) {
  const Json json = parse_outside_json(body);
  JsonReader reader("job", json);
  const auto id = static_cast<int>(reader.member("id").integer(between(0, 1e9)));
  reader.finish();
  if (!asked.jobs.runner.cancel(id)) throw NotFound("there is no job " + std::to_string(id));
  return json_response(Json::object());
}

HttpResponse answer_job_file(const Asked& asked) {
  const std::optional<JobStatusReport> job = asked.jobs.runner.find(asked.integer("id", 0, 1'000'000'000));
  const bool is_done = job && job->state == JobState::Done;
  const std::optional<fs::path> file = is_done ? asked.folder.find(job->request.output) : std::nullopt;
  std::error_code error;
  if (!file || !fs::is_regular_file(*file, error)) throw NotFound("this job has made no file");
  return file_response(*file);
}

}  // namespace patinate::studio
