/// \file
/// Small material histories with known content.
#pragma once

#include <filesystem>
#include <functional>

#include "patinate/history/history.h"
#include "patinate/history/memory_history.h"

namespace patinate::testing_support {

/// Writes a history of `num_frames` frames (times 0, 1, ...) whose color is `color(x, y, frame, channel)` and whose
/// controls "x" and "y" are the pixel coordinates over [0, size - 1].
void write_history(const std::filesystem::path& folder, int width, int height, int num_frames,
                   const std::function<float(int x, int y, int frame, int channel)>& color);

/// The same in memory, at times 0, 1, 4, 9, ..., with colors that half floats hold exactly and controls "x" and "y"
/// over [0, 1].
[[nodiscard]] MemoryHistoryImages half_images(int width, int height, int num_frames,
                                              const std::function<float(int x, int y, int frame, int channel)>& color);
/// Blotches and streaks of several sizes that darken and turn green, from a fixed seed: a texture worth synthesizing.
[[nodiscard]] float blotches(int x, int y, int frame, int channel);

}  // namespace patinate::testing_support
