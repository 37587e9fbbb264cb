/// \file
/// Control maps that took long to compute, kept by what they depend on: the next command that asks for the same map of
/// the same surface reads it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "patinate/controls/control_kinds.h"

namespace patinate {

inline constexpr std::size_t kMaxKeptControls = 64;  ///< Those used last stay.
inline constexpr std::uint64_t kMaxKeptControlBytes = std::uint64_t{1}
                                                      << 30;  ///< Most bytes of all kept controls together.

/// Where maps are kept.
struct ControlCache {
  std::filesystem::path folder = {};  ///< Empty: none is kept. Made when needed; may be removed at any time.
  double least_seconds = 0.5;         ///< Controls that are computed faster are not kept; >= 0.
};

/// Content key of everything that a kind's map depends on: the surface with its UVs, the texels, the options that the
/// kind looks at, the files that it reads, kControlVersion.
/// @throws as control_input_files(); IoError if a file cannot be read.
[[nodiscard]] std::string control_content_key(const std::string& kind, const TexelMap& map,
                                              const ControlKindOptions& options);

/// Gives what make_control() gives, to the bit, and by it unless the same was made before. What cannot be kept (a
/// folder that is read-only, a full disk) is not, and a kept file that is damaged is made again. Never fails for
/// either.
/// @throws as make_control().
[[nodiscard]] ControlMap cached_control(const std::string& kind, const TexelMap& map, const ControlKindOptions& options,
                                        const ControlCache& cache, const RunControl& control = {});

/// cached_control() for make_control_expression(). @param cache  Kept by copy.
[[nodiscard]] ControlSource control_source(ControlCache cache);

}  // namespace patinate
