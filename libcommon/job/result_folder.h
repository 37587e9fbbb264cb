/// \file
/// Folders that a command made and that are whole.
#pragma once

#include <filesystem>

namespace patinate {

/// The finished result (history, transfer, simulation, registration, unlit step, recomposed look, images, factors,
/// evaluation, fit) that a folder is or lies in, or one that is being made (`.partial`); "" when there is none.
/// Captures are not among them: their folder is their user's.
/// @param folder  Absolute; may not exist.
[[nodiscard]] std::filesystem::path result_around(std::filesystem::path folder);

}  // namespace patinate
