#include "capture/project/align_settings.h"

#include <array>
#include <string_view>

namespace patinate::capture {

namespace {

constexpr std::array<std::string_view, 6> kMethods{"off", "auto", "features", "landmarks", "outline", "markers"};
constexpr std::array<std::string_view, 3> kModels{"auto", "similarity", "homography"};
constexpr std::array<std::string_view, 7> kMethodOptions{"project",   "off",     "auto",   "features",
                                                         "landmarks", "outline", "markers"};
constexpr std::array<std::string_view, 4> kModelOptions{"project", "auto", "similarity", "homography"};

}  // namespace

void describe(OptionVisitor& v, AlignOptions& o) {
  v.visit_choice(
      {"align",
       "Align photographs of any size, rotation, scale and crop with the reference one; `project`: as `align` of "
       "capture.json says, else off"},
      o.method, kMethodOptions);
  v.visit_choice(
      {"align_model", "Transformation between photographs; auto: a similarity, unless the matches contradict it"},
      o.model, kModelOptions);
  v.visit({"align_to",
           "PHOTO: file name of the reference photograph, whose frame the history uses; default: the middle one of the "
           "series"},
          o.to);
}

AlignSettings read_align_settings(JsonReader& project, const AlignOptions& options) {
  AlignSettings settings;
  if (project.has("align")) settings.method = static_cast<AlignMethod>(project.member("align").choice(kMethods));
  if (project.has("align_model"))
    settings.model = static_cast<AlignModel>(project.member("align_model").choice(kModels));
  if (project.has("align_to")) settings.to = project.member("align_to").string();
  if (project.has("landmarks")) settings.landmarks = project.member("landmarks").path();
  if (project.has("transforms")) settings.transforms = project.member("transforms").path();
  if (options.method != AlignOptions::Method::Project)
    settings.method = static_cast<AlignMethod>(static_cast<int>(options.method) - 1);
  if (options.model != AlignOptions::Model::Project)
    settings.model = static_cast<AlignModel>(static_cast<int>(options.model) - 1);
  if (!options.to.empty()) settings.to = options.to;
  return settings;
}

std::string align_method_text(AlignMethod method) { return std::string(kMethods[static_cast<std::size_t>(method)]); }
std::string align_model_text(AlignModel model) { return std::string(kModels[static_cast<std::size_t>(model)]); }

}  // namespace patinate::capture
