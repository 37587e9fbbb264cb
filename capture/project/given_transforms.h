/// \file
/// Transforms of photographs that are known already: `alignment.json`, which an ingest writes and a project names.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/project/capture_project.h"

namespace patinate::capture {

/// Name of the file in a history, which `transforms` of a project may name.
inline constexpr const char* kAlignmentFile = "alignment.json";

/// A photograph that was laid over the reference. Files of a user may say only where it lies.
struct PlacedPhoto {
  std::string photo;          ///< Of photo_names().
  std::optional<int> number;  ///< As `exclude` counts.
  std::optional<double> time;
  std::string status;  ///< place_status_text().
  std::optional<int> num_pairs;
  std::optional<Eigen::Matrix3d> reference_from_photo;  ///< Nothing where it fits nothing.
  std::string model;                                    ///< align_model_text().
  std::optional<double> residual_px, pixels_per_reference_pixel, shown_share;
  std::string through;
};
/// Two photographs whose details were compared.
struct MatchedPhotos {
  std::vector<std::string> photos;
  bool is_accepted = false;
  int num_matches = 0, num_agreeing = 0;
};
/// kAlignmentFile.
struct Alignment {
  std::string key, method, reference;
  std::vector<PlacedPhoto> photos;
  std::vector<MatchedPhotos> pairs;
};
/// @throws IoError
[[nodiscard]] Alignment read_alignment(const std::filesystem::path& file);
void save_alignment(const std::filesystem::path& file, Alignment alignment);
[[nodiscard]] Json alignment_schema();

/// The frame whose photo_names() name or file name is `name`.
/// @param what  What names it. @throws IoError naming the project if there is none, or several.
[[nodiscard]] int find_photo(const CaptureProject& project, const std::string& name, const std::string& what);

/// Sets the transforms of the photographs that a file of kAlignmentFile's format places, unless a frame has one of its
/// own; and the reference, unless `align_to` says it. Photographs that the project has not are passed over.
/// @throws IoError
void read_transforms(const std::filesystem::path& file, CaptureProject& project);

}  // namespace patinate::capture
