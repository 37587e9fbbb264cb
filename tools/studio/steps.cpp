// Steps that a capture went through, with their pictures.
#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "libcommon/core/files.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/job/job_record.h"
#include "patinate/image/image_io.h"
#include "tools/studio/opened_capture.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxStepsAtOnce = 10'000;

/// The pictures of one step; those that are not there, or lie outside the place, are excluded.
class StepPictures {
 public:
  explicit StepPictures(const fs::path& folder) : folder_(folder) {}

  void add(const fs::path& file, const std::string& caption) {
    std::error_code error;
    const fs::path path = file.is_absolute() ? file : folder_ / file;
    const fs::path relative = fs::weakly_canonical(path, error).lexically_relative(folder_);
    if (error || relative.empty() || *relative.begin() == ".." || !fs::is_regular_file(path, error)) return;
    json_.push_back({{"path", relative.generic_string()}, {"caption", caption}});
  }
  /// One that lies in another place.
  void add_of(const ServedFolder& served, const fs::path& place, const fs::path& file, const std::string& caption) {
    std::error_code error;
    const fs::path folder = fs::is_directory(place, error) ? place : place.parent_path();
    const fs::path relative = fs::weakly_canonical(file, error).lexically_relative(folder);
    if (error || relative.empty() || *relative.begin() == ".." || !fs::is_regular_file(file, error)) return;
    json_.push_back({{"place", served.name_of(place)}, {"path", relative.generic_string()}, {"caption", caption}});
  }
  [[nodiscard]] Json take() { return std::exchange(json_, Json::array()); }

 private:
  fs::path folder_;
  Json json_ = Json::array();
};

Json step(const std::string& name, const std::string& text, Json pictures) {
  return {{"name", name}, {"text", text}, {"pictures", std::move(pictures)}};
}

std::string time_text(double time, TimeUnit unit) { return short_number_text(time) + " " + shown_time_unit(unit); }

Json relit_capture_steps(const capture::RelitProject& project, StepPictures& pictures) {
  Json steps = Json::array();
  for (const capture::RelitStep& s : project.steps) {
    for (std::size_t i = 0; i < s.photos.size(); ++i) pictures.add(s.photos[i], "light " + std::to_string(i + 1));
    if (s.ambient) pictures.add(*s.ambient, "without lamps");
    if (s.ready) pictures.add(s.ready->albedo, "albedo");
    std::string text = std::to_string(s.photos.size()) + " photographs";
    if (s.scan) text += ", scan " + s.scan->filename().string();
    steps.push_back(step(time_text(s.time, project.time_unit), text, pictures.take()));
  }
  return steps;
}

Json fixed_capture_steps(const capture::CaptureProject& project, StepPictures& pictures) {
  Json steps = Json::array();
  if (project.transmission) {
    pictures.add(project.transmission->photo, "on the back-light");
    if (project.transmission->blank) pictures.add(*project.transmission->blank, "the back-light alone");
    steps.push_back(step("Thickness", "What the back-light shows of the layer", pictures.take()));
  }
  for (const capture::CapturePhoto& frame : project.frames) {
    if (steps.size() == kMaxStepsAtOnce) break;
    if (!frame.stream) pictures.add(frame.file, frame.name());
    steps.push_back(step(time_text(frame.time, project.time_unit), "", pictures.take()));
  }
  return steps;
}

/// Text on registration and unlighting of one step of a relit ingest.
std::string fact_text(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  const Json facts = load_json(file);
  std::string text = facts.value("status", "");
  const auto add = [&](const char* key, const std::string& before, const std::string& after) {
    if (!facts.contains(key) || !facts.at(key).is_number()) return;
    text += (text.empty() ? "" : "; ") + before + short_number_text(rounded(facts.at(key).get<double>(), 3)) + after;
  };
  add("rms_mm", "registered to ", " mm");
  add("registration_overlap", "overlap ", "");
  return text;
}

/// The capture that an ingest was given, where run.json still leads to it from the folder in which it ran.
std::optional<fs::path> capture_of(const ServedFolder& served, const fs::path& history) {
  const auto words = load_json(history / kRunRecordFile).at("command").get<std::vector<std::string>>();
  const auto output =
      std::find_if(words.begin(), words.end(), [](const auto& w) { return w == "-o" || w == "--output"; });
  if (words.end() - output < 2 || words.size() < 3 || words[1] != "ingest" || words[2].starts_with("-")) return {};
  fs::path made = fs::path(output[1]).lexically_normal(), ran_in = history;
  if (!made.has_filename()) made = made.parent_path();
  for (auto part = made.begin(); part != made.end(); ++part) ran_in = ran_in.parent_path();
  if (made.is_absolute() || ran_in / made != history) return {};
  const fs::path asked = (ran_in / words[2]).lexically_normal();
  const std::optional<fs::path> found = served.find(asked.lexically_relative(served.path()).string());
  if (!found) return {};
  const fs::path place = found->filename() == "capture.json" ? found->parent_path() : *found;
  const bool is_fixed =
      place_kind(place) == PlaceKind::Ingest && !capture::is_relit_capture(capture::capture_file(place));
  return is_fixed ? std::optional(place) : std::nullopt;
}

/// Photographs of which frames were made, as they were before.
class RawPhotographs {
 public:
  RawPhotographs(const ServedFolder& served, const fs::path& history) : served_(served), history_(history) {
    try {
      const std::optional<fs::path> capture = capture_of(served, history);
      if (!capture) return;
      place_ = *capture;
      project_ = capture::read_capture_project(capture::capture_file(place_));
      for (const capture::CapturePhoto& photo : project_.frames) photos_[photo.time] = &photo;
    } catch (const std::exception&) {
      photos_.clear();  // They are not there any more: the frames are shown alone.
    }
  }
  RawPhotographs(const RawPhotographs&) = delete;
  RawPhotographs& operator=(const RawPhotographs&) = delete;

  void add(const HistoryFrame& frame, StepPictures& pictures) const {
    const auto found = photos_.find(frame.time);
    if (found == photos_.end() || found->second->stream) return;
    pictures.add_of(served_, place_, found->second->file, "the photograph");
    pictures.add(frame.file, "what became of it");
  }
  /// Both, to be looked at with one zoom; "roi" is the part of the photograph that the frame shows, if it is known.
  /// Null if there is no photograph.
  [[nodiscard]] Json beside(const HistoryManifest& m, const HistoryFrame& frame) const {
    const auto found = photos_.find(frame.time);
    if (found == photos_.end()) return nullptr;
    const capture::CapturePhoto& photo = *found->second;
    Json raw = photo_json(project_.file.parent_path(), photo, photo.name());
    const std::string path = shown_path(history_, history_ / frame.file);
    if (raw.is_null() || path.empty()) return nullptr;
    raw["place"] = served_.name_of(place_);
    const auto& roi = project_.roi;
    const bool is_known = !project_.is_handheld() && m.width == project_.width() && m.height == project_.height();
    return {{"photo", std::move(raw)},
            {"frame",
             {{"path", path}, {"name", time_text(frame.time, m.time_unit)}, {"width", m.width}, {"height", m.height}}},
            {"roi", is_known ? Json{roi.x, roi.y, roi.width, roi.height} : Json(nullptr)}};
  }

 private:
  const ServedFolder& served_;
  fs::path history_, place_;
  capture::CaptureProject project_;
  std::map<double, const capture::CapturePhoto*> photos_;
};

/// Records of an ingest beside its history: pictures of every step (relit), or what was found in every photograph
/// (fixed).
Json history_steps(const ServedFolder& served, const fs::path& folder, StepPictures& pictures) {
  Json steps = Json::array();
  const HistoryManifest m = read_history_manifest(folder);
  const RawPhotographs raw(served, folder);
  for (std::size_t i = 0; i < m.frames.size() && i < kMaxStepsAtOnce; ++i) {
    const std::string number = zero_padded(i, 4);
    const fs::path report = "report";
    raw.add(m.frames[i], pictures);
    pictures.add(report / ("light_" + number + ".png"), "a photograph in the reference's view");
    pictures.add(report / ("albedo_" + number + ".png"), "albedo");
    pictures.add(report / ("stddev_" + number + ".png"), "standard deviation of the albedo");
    pictures.add(report / ("samples_" + number + ".png"), "what became of every photograph's pixels");
    pictures.add(report / ("validity_" + number + ".png"), "where the frame shows the surface");
    pictures.add(fs::path("survey") / ("validity-" + number + ".png"), "where the photograph shows the surface");
    if (m.frames[i].mask) pictures.add(*m.frames[i].mask, "mask");
    Json shown = pictures.take();
    const std::string text = fact_text(folder / report / ("facts_" + number + ".json"));
    Json beside = raw.beside(m, m.frames[i]);
    if (shown.empty() && text.empty() && beside.is_null()) continue;
    steps.push_back(step(time_text(m.frames[i].time, m.time_unit), text, std::move(shown)));
    if (!beside.is_null()) steps.back()["beside"] = std::move(beside);
  }
  return steps;
}

Json registration_steps(StepPictures& pictures) {
  pictures.add("registration.png", "before and after, each scan in its color, from aside and cut through");
  return Json::array({step("Before and after", "All scans, where they were and where they are", pictures.take())});
}

/// Text on what the others predict of a photograph, and by how much it is off.
std::string light_text(const Json& lights, std::size_t i) {
  if (!lights.is_array() || i >= lights.size()) return {};
  const Json& light = lights[i];
  std::string text;
  if (light.contains("residual") && light.at("residual").is_number())
    text += ": residual " + percent_text(light.at("residual").get<double>());
  if (light.contains("leave_one_out") && light.at("leave_one_out").is_object() &&
      light.at("leave_one_out").contains("median") && light.at("leave_one_out").at("median").is_number()) {
    text +=
        ", predicted from the others " + percent_text(light.at("leave_one_out").at("median").get<double>()) + " off";
  }
  return text;
}

Json unlit_steps(const fs::path& folder, StepPictures& pictures) {
  Json steps = Json::array();
  constexpr std::array<std::array<const char*, 2>, 5> kMaps{{{"albedo", "albedo"},
                                                             {"normal", "normal, in scanner coordinates"},
                                                             {"specular", "strength of the highlight"},
                                                             {"stddev", "standard deviation of the albedo"},
                                                             {"mask", "where it is known"}}};
  for (const auto& [name, caption] : kMaps) pictures.add(std::string(name) + ".png", caption);
  steps.push_back(step("Maps", "What the photographs under known lamps gave", pictures.take()));
  Json json = load_json(folder / "unlight.json");
  update_spelling(json, 1, {{"left_out", "leave_one_out"}});
  const Json lights = json.contains("lights") ? json.at("lights") : Json::array();
  std::error_code error;
  if (fs::is_directory(folder / "samples", error) && may_read(folder / "samples")) {
    std::size_t number = 0;
    for (const fs::path& file : list_files(folder / "samples", "*.png")) {
      pictures.add(file, "light " + std::to_string(number + 1) + light_text(lights, number));
      ++number;
    }
    steps.push_back(
        step("Photographs",
             "What became of every photograph's pixels. Gray: clean. Black: the surface faces away. Blue: in a cast "
             "shadow. Cyan: darker than the other lamps allow. Red: brighter. Magenta: saturated or out of view",
             pictures.take()));
  }
  return steps;
}

}  // namespace

Json steps_json(const ServedFolder& folder, const fs::path& path, PlaceKind kind) {
  std::error_code error;
  StepPictures pictures(fs::is_directory(path, error) ? path : path.parent_path());
  switch (kind) {
    case PlaceKind::Ingest: {
      const fs::path file = capture::capture_file(path);
      return capture::is_relit_capture(file) ? relit_capture_steps(capture::read_relit_project(file), pictures)
                                             : fixed_capture_steps(capture::read_capture_project(file), pictures);
    }
    case PlaceKind::History:
      return history_steps(folder, path, pictures);
    case PlaceKind::Registration:
      return registration_steps(pictures);
    case PlaceKind::Unlit:
      return unlit_steps(path, pictures);
    default:
      return Json::array();
  }
}

}  // namespace patinate::studio
