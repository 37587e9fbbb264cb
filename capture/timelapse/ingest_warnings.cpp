#include "capture/timelapse/ingest_warnings.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

std::string photo_text(const SurveyPhoto& photo) {
  return photo.name + " (time " + short_number_text(photo.time) + ")";
}

double share_of(std::size_t count, int num_frames) {
  return std::min(1.0, static_cast<double>(count) / std::max(1, num_frames));
}

/// "\"exclude\": [3, 7]", with what the project excludes already.
std::string exclude_text(const SurveyReport& survey, const std::vector<SurveyPhoto>& photos) {
  std::set<int> numbers(survey.excluded.begin(), survey.excluded.end());
  for (const SurveyPhoto& photo : photos) numbers.insert(photo.number);
  std::string list;
  for (int number : numbers) list += (list.empty() ? "" : ", ") + std::to_string(number);
  return "\"exclude\": [" + list + "] in capture.json";
}

struct Group {
  std::vector<SurveyPhoto> photos;  ///< Each once.
  SurveyPhoto worst;
  SurveyProblem problem;  ///< Problem of the worst.

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const SurveyPhoto& photo : photos) names.push_back(photo.name);
    return names;
  }
};

Group group_findings(const SurveyReport& survey, SurveyProblem SurveyFinding::*kind) {
  Group group;
  for (const SurveyFinding& finding : survey.findings) {
    const SurveyProblem& problem = finding.*kind;
    const auto is_same = [&](const SurveyOutsider& o) {
      return o.photo.name == finding.photo.name || o.photo.name == finding.against;
    };
    const bool is_outside = std::any_of(survey.unlinked.begin(), survey.unlinked.end(), is_same);
    if (problem.text.empty() || is_outside) continue;  // Only this is said of photographs that cannot be compared.
    const bool is_known = std::any_of(group.photos.begin(), group.photos.end(),
                                      [&](const SurveyPhoto& p) { return p.name == finding.photo.name; });
    if (!is_known) group.photos.push_back(finding.photo);
    if (!group.problem.text.empty() && problem.size <= group.problem.size) continue;
    group.worst = finding.photo;
    group.problem = problem;
  }
  return group;
}

/// Findings of one kind as one warning; the largest change is quoted.
void add_group(std::vector<HistoryWarning>& warnings, const Group& group, int num_frames, WarningSubject about,
               const std::string& what, const std::string& cure) {
  if (group.photos.empty()) return;
  HistoryWarning warning{.about = about, .text = "", .cure = cure, .photos = group.names()};
  const std::string worst = photo_text(group.worst);
  if (group.photos.size() == 1) {
    warning.text = worst + ": " + group.problem.text;
  } else {
    warning.text = std::to_string(group.photos.size()) + " of " + std::to_string(num_frames) + " photographs " + what +
                   " (" + photo_list(warning.photos) + "); the worst is " + worst + ", " + group.problem.text;
  }
  warning.share = share_of(group.photos.size(), num_frames);
  warnings.push_back(std::move(warning));
}

std::string look_and_leave_out(const SurveyReport& survey, const std::vector<SurveyPhoto>& photos,
                               const std::string& what) {
  return std::string(photos.size() == 1 ? "look at it, and leave it out if it shows "
                                        : "look at them, and leave out those that show ") +
         what + ": " + exclude_text(survey, photos);
}

/// " (similarity 0.09 of 1)" of the one that fits worst; nothing when none was measured.
std::string lowest_similarity_text(const std::vector<SurveyOutsider>& outsiders) {
  std::optional<double> lowest;
  for (const SurveyOutsider& o : outsiders) {
    if (o.similarity) lowest = std::min(lowest.value_or(1.0), *o.similarity);
  }
  if (!lowest) return "";
  return " (similarity " + short_number_text(std::max(0.0, std::round(100.0 * *lowest) / 100.0)) + " of 1)";
}

/// Photographs that --stabilize leaves as they lie because they show nothing to be laid by.
void add_plain(std::vector<HistoryWarning>& warnings, const std::vector<std::string>& names, int num_frames) {
  if (names.empty()) return;
  const bool is_one = names.size() == 1;
  warnings.push_back(
      {.about = WarningSubject::Motion,
       .text = photo_list(names) + (is_one ? " shows" : " show") +
               " too little detail to be aligned with the others, and " +
               (is_one ? "stays as it is" : "stay as they are"),
       .cure = std::string("check that ") + (is_one ? "it shows" : "they show") + " the same view as the others",
       .share = 0.5 * share_of(names.size(), num_frames),
       .photos = names});
}

/// Photographs that no motion brings onto the others.
void add_unlinked(std::vector<HistoryWarning>& warnings, const SurveyReport& survey, int num_frames) {
  std::vector<SurveyOutsider> unlinked;
  std::vector<std::string> plain;
  for (const SurveyOutsider& outsider : survey.unlinked) {
    if (outsider.is_plain) plain.push_back(outsider.photo.name);
    if (!outsider.is_plain) unlinked.push_back(outsider);
  }
  add_plain(warnings, plain, num_frames);
  if (unlinked.empty()) return;
  const std::size_t count = unlinked.size();
  std::vector<SurveyPhoto> photos;
  HistoryWarning warning{.about = survey.is_stabilized ? WarningSubject::Motion : WarningSubject::Series,
                         .text = "",
                         .cure = "",
                         .share = share_of(count, num_frames)};
  for (const SurveyOutsider& outsider : unlinked) {
    photos.push_back(outsider.photo);
    warning.photos.push_back(outsider.photo.name);
  }
  if (static_cast<int>(count) >= num_frames) {
    warning.text = "none of the " + std::to_string(num_frames) + " photographs can be aligned with another one";
  } else if (count == 1) {
    warning.text = photo_text(photos.front()) + " cannot be aligned with the others";
  } else {
    warning.text = std::to_string(count) + " of " + std::to_string(num_frames) +
                   " photographs cannot be aligned with the others (" + photo_list(warning.photos) + ")";
  }
  warning.text += "; no shift, rotation or scale explains the difference" + lowest_similarity_text(unlinked) +
                  (!survey.is_stabilized ? ""
                   : count == 1          ? "; it stays as it is"
                                         : "; they stay as they are");
  constexpr double kMost = 0.5;  // Share of the pixels.
  warning.cure = warning.share > kMost ? "use photographs of one view, with equal crop and rotation"
                                       : look_and_leave_out(survey, photos, "another view, crop or object");
  warnings.push_back(std::move(warning));
}

/// Photographs that would follow one another much better in another order.
void add_order(std::vector<HistoryWarning>& warnings, const SurveyReport& survey) {
  if (survey.better_order.empty()) return;
  std::vector<std::string> names;
  for (const SurveyPhoto& photo : survey.better_order) names.push_back(photo.name);
  warnings.push_back(
      {.about = WarningSubject::Series,
       .text = "the photographs follow one another better in another order: " + photo_list(names) +
               " (consecutive differences are now " + short_number_text(std::round(10.0 * survey.detour) / 10.0) +
               " times as large)",
       .cure = "check names and times; survey.json has the whole order (`better_order`), from the first or from the "
               "last; if the times are right, the light or the camera went to and fro",
       .share = 1.0});
}

/// Light in which a photograph that is exposed differently does not stand out.
void add_restless_light(std::vector<HistoryWarning>& warnings, const RestlessLight& light) {
  const std::string channel(kChannelNames[light.channel]);
  warnings.push_back(
      {.about = WarningSubject::Light,
       .text = "the light or its color varies from photograph to photograph, by " +
               short_number_text(std::round(100.0 * light.deviation)) + " % in " + channel +
               ", so that a photograph whose exposure differs by less than " +
               short_number_text(std::round(10.0 * light.hidden) / 10.0) + " times cannot be detected",
       .cure = "use --deflicker, or better a gray card in the picture (`reference_patch`); lock exposure and white "
               "balance",
       .share = light.deviation / (1.0 + light.deviation)});
}

/// "copper.webp, image 57" -> its file and the number; the number is empty of a photograph.
std::pair<std::string, std::string> split_image(const std::string& name) {
  constexpr std::string_view kImage = ", image ";
  const std::size_t at = name.rfind(kImage);
  if (at == std::string::npos) return {name, ""};
  return {name.substr(0, at), name.substr(at + kImage.size())};
}

}  // namespace

std::string photo_list(const std::vector<std::string>& photos, std::size_t most) {
  std::string list, last_file;
  const std::size_t shown = photos.size() <= most + 1 ? photos.size() : most;  // "and 1 more" is no shorter.
  for (std::size_t i = 0; i < shown; ++i) {
    const auto [file, image] = split_image(photos[i]);
    const bool is_same_file = !image.empty() && file == last_file;
    const bool is_next_same = i + 1 < shown && !image.empty() && split_image(photos[i + 1]).first == file;
    if (is_same_file) {
      list += ", " + image;
    } else {
      list += (i == 0 ? "" : ", ") + (is_next_same ? file + ", images " + image : photos[i]);
    }
    last_file = image.empty() ? "" : file;
  }
  return shown == photos.size() ? list : list + " and " + std::to_string(photos.size() - shown) + " more";
}

std::vector<HistoryWarning> survey_warnings(const SurveyReport& survey, int num_frames, bool is_aligned) {
  std::vector<HistoryWarning> warnings;
  const Group moved = group_findings(survey, &SurveyFinding::moved);
  const Group exposed = group_findings(survey, &SurveyFinding::exposed);
  const Group unclear = group_findings(survey, &SurveyFinding::unclear);
  const Group jumping = group_findings(survey, &SurveyFinding::jump);
  const auto or_leave_out = [&](const Group& group) {
    return group.photos.size() == 1 && num_frames > 2 ? "; or leave it out: " + exclude_text(survey, group.photos) : "";
  };
  if (!is_aligned)
    add_unlinked(warnings, survey, num_frames);  // Photographs of an aligned series were compared already.
  add_order(warnings, survey);
  if (!survey.is_stabilized) {
    add_group(warnings, moved, num_frames, WarningSubject::Motion, "moved relative to the photographs before them",
              (is_aligned ? "`landmarks`, or another `align`, if the object itself has not moved"
                          : "--stabilize aligns them with each other") +
                  or_leave_out(moved));
  }
  if (!survey.is_deflickered) {
    add_group(warnings, exposed, num_frames, WarningSubject::Light,
              "have another exposure than the photographs before them",
              "--deflicker takes it out" + or_leave_out(exposed));
    if (survey.restless_light) add_restless_light(warnings, *survey.restless_light);
  }
  add_group(warnings, unclear, num_frames, WarningSubject::Light,
            "are brighter or darker than the photographs before them, because of the light or of the surface itself",
            "check them; --deflicker only corrects changes that most of the picture shares");
  add_group(warnings, jumping, num_frames, WarningSubject::Series, "differ abruptly from the photographs before them",
            look_and_leave_out(survey, jumping.photos, "something else"));
  return warnings;
}

std::string hundredths(double v) { return short_number_text(std::round(100.0 * v) / 100.0); }

}  // namespace patinate::capture
