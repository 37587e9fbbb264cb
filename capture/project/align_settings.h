/// \file
/// How photographs that no fixed camera took become one series: what a project says of it, and what a command changes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "capture/handheld/photo_pair.h"
#include "patinate/core/json.h"
#include "patinate/core/options.h"

namespace patinate::capture {

enum class AlignMethod {
  Off,        ///< Photographs lie as they are, all of one size.
  Auto,       ///< By landmarks where they are given, by features for all.
  Features,   ///< By details of the surface.
  Landmarks,  ///< By points that the user marked.
  Outline,    ///< By the border of the object before a plain background.
  Markers,    ///< By printed markers beside it.
};

struct AlignSettings {
  AlignMethod method = AlignMethod::Off;
  AlignModel model = AlignModel::Auto;
  std::string to = "";  ///< File name of the reference photograph; "" = the one in the middle of the series.
  std::optional<std::filesystem::path> landmarks;   ///< CSV: photo,point,x,y.
  std::optional<std::filesystem::path> transforms;  ///< `alignment.json` of an earlier run.
};

/// Settings that the command line gives instead of the project.
struct AlignOptions {
  enum class Method { Project, Off, Auto, Features, Landmarks, Outline, Markers } method = Method::Project;
  enum class Model { Project, Auto, Similarity, Homography } model = Model::Project;
  std::string to = "";  ///< "" = as the project says.
};
void describe(OptionVisitor& v, AlignOptions& o);

/// Members `align`, `align_model`, `align_to`, `landmarks` and `transforms` of a project, then the options over them.
/// @throws IoError
[[nodiscard]] AlignSettings read_align_settings(JsonReader& project, const AlignOptions& options);
/// "features".
[[nodiscard]] std::string align_method_text(AlignMethod method);
/// "similarity".
[[nodiscard]] std::string align_model_text(AlignModel model);

}  // namespace patinate::capture
