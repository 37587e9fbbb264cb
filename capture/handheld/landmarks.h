/// \file
/// Points of the object that a person marked in the photographs.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "capture/handheld/photo_pair.h"

namespace patinate::capture {

/// Pixels of a photograph by the point's name; pixel centers are whole numbers.
using PhotoMarks = std::map<std::string, Eigen::Vector2d>;

/// By the name of the photograph, as the table has it. Lines `photo,point,x,y`; fields may stand in double quotes; a
/// first line of those four words, empty lines and lines that start with # are passed over.
/// @throws IoError naming the line: it has not four fields, a position is no number, or a point is marked twice in one
/// photograph.
[[nodiscard]] std::map<std::string, PhotoMarks> read_landmarks(const std::filesystem::path& file);

/// The table that read_landmarks() reads back as `marks`: photographs and points in the order of their names.
/// @throws InvalidInput naming a photograph or point that a line of the table cannot name: one with a line break, or
/// with blanks at an end; or if there is no point.
[[nodiscard]] std::string landmarks_text(const std::map<std::string, PhotoMarks>& marks);

/// Points that both have, in the order of their names.
[[nodiscard]] std::vector<PointMatch> shared_marks(const PhotoMarks& a, const PhotoMarks& b);

/// Error of a mark in a photograph whose longer side is `side` pixels: two pixels of 1600, as by a click
/// into a picture that fills a screen.
[[nodiscard]] double mark_error_px(int side);

}  // namespace patinate::capture
