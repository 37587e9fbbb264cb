#include "tools/patinate/commands/declared_options.h"

#include <map>

#include "libcommon/controls/control_arguments.h"
#include "tools/patinate/command_line/option_values.h"

namespace patinate::cli {

namespace {

/// Declarations of the options of kinds, by their keys.
std::map<std::string, Argument> declared_kind_options() {
  std::map<std::string, Argument> all;
  ControlKindOptions options;
  Described<ControlKindOptions> described(options);
  declare_options(described, [&](Argument argument) { all[argument.key()] = std::move(argument); });
  return all;
}

bool is_text(const Argument& argument) {
  return argument.kind == ArgumentKind::Option && argument.type == ValueType::Text && argument.choices.empty();
}

/// "is an argument of the kind now: exposure(up=z) or sun(up=z)".
std::string argument_advice(const std::string& key, const std::string& value) {
  const std::string shown = is_text(declared_kind_options().at(key)) ? "\"" + value + "\"" : value;
  std::string list;
  for (const std::string& kind : control_kind_names()) {
    for (const auto& [option, name] : control_argument_names(kind)) {
      if (option == key) list += (list.empty() ? "" : " or ") + kind + "(" + name + "=" + shown + ")";
    }
  }
  return "is written in the control now, as " + list;
}

}  // namespace

void declare_kind_options(CommandLine& line, ControlKindOptions& options, const std::vector<std::string>& kept) {
  line.moved_options(options, argument_advice, kept);
}

std::vector<std::pair<std::string, std::string>> kind_argument_rows() {
  const std::map<std::string, Argument> declared = declared_kind_options();
  std::vector<std::pair<std::string, std::string>> rows;
  for (const std::string& kind : control_kind_names()) {
    for (const auto& [option, name] : control_argument_names(kind)) {
      Argument argument = declared.at(option);
      const bool is_flag = argument.kind == ArgumentKind::Flag;
      if (is_flag) argument.default_text = argument.has_no_form ? "true" : "false";
      argument.has_no_form = false;
      rows.emplace_back(kind + "(" + name + "=" + (is_flag ? "true|false" : argument.value_name) + ")",
                        argument.description());
    }
  }
  return rows;
}

std::optional<ControlName> single_kind(const std::string& text) {
  const ControlExpression expression(text, control_kind_names());
  const ControlName* const name = expression.alone();
  if (name == nullptr || name->is_file || (name->text != text && name->arguments.empty())) return std::nullopt;
  return *name;
}

void declare_mesh(CommandLine& line, app::MeshSource& source) {
  line.positional("MESH", "OBJ, PLY, STL, glTF or GLB", source.path);
  line.option("unit", "um|mm|cm|m",
              "Length unit of the mesh file (glTF is always in m); without it, sizes are relative", source.unit);
  line.suggestions({"um", "mm", "cm", "m"});
  line.option("node", "NAME", "Only the surfaces of this node", source.node);
  line.option("material", "NAME", "Only the surfaces of this material", source.material);
}

}  // namespace patinate::cli
