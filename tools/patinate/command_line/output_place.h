/// \file
/// Whether what a command makes would take the place of what it reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace patinate::cli {

/// What was given for an argument other than the output.
struct GivenInput {
  std::string argument;  ///< As shown: "MESH", "--time-map".
  std::string text;
  bool is_path = true;  ///< false: a text that may name files, such as SOURCE=MAP:2 or an expression.
};

/// @param argument  That names the output, as shown: "-o".
/// @throws UsageError if `output` is an input, is a folder that holds one, or lies in a folder that patinate made, of
/// which it is no part.
void require_apart(const std::string& argument, const std::filesystem::path& output,
                   const std::vector<GivenInput>& inputs);

}  // namespace patinate::cli
