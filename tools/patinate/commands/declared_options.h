/// \file
/// Options of kinds of control on a command line. They stand in the control's text, `accessibility(scale=3)`; as
/// options they are accepted from those who know them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/mesh/mesh_source.h"
#include "libcommon/controls/control_expression.h"
#include "patinate/controls/control_kinds.h"
#include "tools/patinate/command_line/command_line.h"

namespace patinate::cli {

/// @param kept  Keys of options that the command has for itself too.
void declare_kind_options(CommandLine& line, ControlKindOptions& options, const std::vector<std::string>& kept = {});
/// {"accessibility(scale=X)", what it is}, of every kind.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> kind_argument_rows();
/// A control that is one kind, with arguments or without; nothing else. @throws ParseError
[[nodiscard]] std::optional<ControlName> single_kind(const std::string& text);

/// Declares MESH, --unit, --node and --material.
void declare_mesh(CommandLine& line, app::MeshSource& source);

}  // namespace patinate::cli
