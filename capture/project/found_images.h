/// \file
/// Images in a folder, and which of them may be the frames of a project.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "patinate/image/image_io.h"

namespace patinate::capture {

struct FoundImage {
  std::filesystem::path file;
  ImageInfo info;
};

/// What an image is by its name.
enum class Part { Photo, Transmission, Blank, Mask };
[[nodiscard]] Part part_of(const std::filesystem::path& file);

/// Whether a file is an image, camera RAW or a movie, by its name.
[[nodiscard]] bool may_be_photograph(const std::filesystem::path& file);

/// Every image in the folder and the folders directly in it, in natural order; hidden folders, and what patinate made,
/// are skipped. @param to_check  Is added to: images that cannot be read. @throws IoError if `folder` cannot be listed.
[[nodiscard]] std::vector<FoundImage> find_images(const std::filesystem::path& folder,
                                                  std::vector<std::string>& to_check);

/// A movie, or a file with several pictures.
[[nodiscard]] bool has_many(const FoundImage& image);
[[nodiscard]] bool same_size(const FoundImage& a, const FoundImage& b);
/// Null when none is of that part.
[[nodiscard]] const FoundImage* first_of(const std::vector<FoundImage>& images, Part part);

/// Candidates for the frames of a project: the photographs that share folder, format and size, or one movie.
[[nodiscard]] std::vector<std::vector<FoundImage>> frame_sets(
    const std::vector<FoundImage>& images, const std::function<bool(const std::filesystem::path&)>& is_wanted);

/// All photographs as one series taken by hand. Nothing where a movie is among them, or where pictures of one name
/// stand in several sets: smaller copies, or RAW beside JPEG.
/// @param images  All that were found, in order.
[[nodiscard]] std::optional<std::vector<FoundImage>> by_hand(const std::vector<std::vector<FoundImage>>& sets,
                                                             const std::vector<FoundImage>& images);

/// A project that left some of the photographs out in silence would look whole. @throws IoError that lists the sets.
[[noreturn]] void refuse_several(const std::filesystem::path& folder, const std::vector<std::vector<FoundImage>>& sets);

}  // namespace patinate::capture
