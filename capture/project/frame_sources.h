/// \file
/// Which images make the frames of a project: photographs, and the images of movies and animated files; and their
/// times.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/image/frame_stream.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

struct CapturePhoto {
  double time = 0.0;  ///< In the project's time unit.
  std::filesystem::path file;
  bool has_alpha = false;       ///< Transparent pixels are outside the mask.
  bool has_codes = true;        ///< Integers, which become light through the response; not those of camera RAW.
  bool is_raw = false;          ///< Camera RAW: linear light that ends at 1.
  bool is_encoded = false;      ///< Its color is not sRGB codes or linear Rec. 709, as the file says.
  ImageFacts facts = {};        ///< Facts of the file on how it is to be seen.
  ImageExposure exposure = {};  ///< Exposure as EXIF says it.
  std::string said_time = {};   ///< Time that the file alone states, as photo_time_text(); "" of one of many images.
  int image = 0;                ///< Number of the image in the file.
  int width = 0;                ///< Pixels.
  int height = 0;
  int number = 0;  ///< Among all that the project lists, from 0, as `exclude` counts.
  std::shared_ptr<FrameStream> stream =
      nullptr;  ///< Where the images of a file with many come from; null for photographs.
  std::optional<Eigen::Matrix3d> transform = {};  ///< Reference from photograph, pixel centers; as it is given.

  /// "day07.jpg", or "copper.webp, image 12".
  [[nodiscard]] std::string name() const;
};

/// name() of each; where several have one (equal names in different folders), "day07.jpg (number 7)". All different.
[[nodiscard]] std::vector<std::string> photo_names(const std::vector<CapturePhoto>& photos);

inline constexpr const char* kPresentationTimes = "when the movie shows its images";

struct FrameSources {
  std::vector<CapturePhoto> photos;  ///< By strictly increasing time; one or more.
  std::string time_source;  ///< "interval", "list", "when the movie shows its images", "the movie's frame rate", or as
                            ///< FrameTimes says it.
  std::string time_span = {};                      ///< Time span as FrameTimes says it; "" where it has no dates.
  std::vector<HistoryWarning> time_warnings = {};  ///< Where sources of times disagree.
  bool is_raw = false;                             ///< At least one of them is camera RAW.
  std::vector<int> excluded = {};                  ///< Numbers of `exclude`; rising.
  int num_images = 0;                              ///< That the project lists, excluded ones too.
};

/// A photograph as its file has it; time, number and transform are not set.
[[nodiscard]] CapturePhoto photo_of(const std::filesystem::path& file, const ImageInfo& info);

/// Nine numbers, row by row: an invertible map between pixel centers; its lower right becomes 1. @throws IoError
[[nodiscard]] Eigen::Matrix3d read_transform(const JsonReader& json);

/// Reads `frames` and `exclude` of a project, opens every file, and finds the times that are not given. Images count
/// from 0 through all files in order; `from`, `to`, `every` and `exclude` choose among them and leave the times of the
/// others alone. Their sizes may differ.
/// @param json  The project. @throws IoError naming the file or the place in the project that is wrong.
[[nodiscard]] FrameSources read_frame_sources(JsonReader& json, TimeUnit unit);

}  // namespace patinate::capture
