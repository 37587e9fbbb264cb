/// \file
/// Pictures of a factorization's page. Inside of it only.
#pragma once

#include <filesystem>

#include "analysis/compare/sections.h"
#include "analysis/factorization/factorization_work.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// Reduces a picture to the size that a page shows.
[[nodiscard]] ImageF shown(ImageF image);

/// A map at some times, in the history and as the factors make it: black to white over what the history knows.
/// @param work  Of a map, not of color. @param folder  With the denoised history.
void add_map_strips(const FactorizationWork& work, const std::filesystem::path& folder, Section& section);

}  // namespace patinate::analysis
