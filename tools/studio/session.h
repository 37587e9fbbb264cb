/// \file
/// A place as one HTML file that opens without a server: the client with the answers that it will ask for.
#pragma once

#include <string>
#include <vector>

#include "patinate/core/run_control.h"

namespace patinate::studio {

struct Asked;

struct SessionOptions {
  std::string place;          ///< A history, transfer or simulation.
  std::vector<double> times;  ///< Whose textures are in the file; none: those of its frames.
  int size = 1024;            ///< Longest side of a texture, texels; [16, 8192]. Control maps are half as large.
  std::string view = "null";  ///< How it looks when it is opened: JSON, as the client left it.
};

/// Textures as PNG, the mesh, control maps, and where texels come from.
/// @param asked  Its target is not looked at. @throws NotFound, InvalidInput if the place has no color over time or the
/// file would have more than 512 MB; CannotComplete where the program was built without its client; Canceled.
[[nodiscard]] std::string make_session(const Asked& asked, const SessionOptions& options);
/// JSON of the body of a request. @throws InvalidInput
[[nodiscard]] SessionOptions parse_session_options(const std::string& body);

}  // namespace patinate::studio
