/// \file
/// Whether a series shows one object before a plain background.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace patinate::capture {

struct PlainObject {
  double share = 0.0;      ///< Part of the picture that the object takes, (0, 1): the least of the photographs.
  bool has_moved = false;  ///< It lies elsewhere in some photograph.
};

/// Looks at three photographs, the first, the middle and the last. The background has to be plain
/// (PlainBackground::is_plain()) and of one color in all of them, and what stands out has to be one large object in
/// each, which does not reach from one side of the picture to the opposite side: a coat that changes in places looks
/// alike in its first photograph, and a band across the picture belongs to the sample.
/// @param photographs  Files that read_color() reads. @return Nothing where there is no such object, where a photograph
/// is cut out already or cannot be read.
[[nodiscard]] std::optional<PlainObject> find_plain_object(const std::vector<std::filesystem::path>& photographs);

}  // namespace patinate::capture
