/// \file
/// Parts of patinate that stand on libraries which most runs never use: loaded when first asked for. Linked, those
/// libraries would cost every command a third of a second before main() (docs/decisions/0012-modules.md).
#pragma once

#include <string>

namespace patinate {

/// The function `symbol` (extern "C") of the module `name`, say "patinate-media", whose file NAME.so is loaded by the
/// first call and stays. It is looked for in the folder that $PATINATE_MODULES names and nowhere else; without that
/// variable beside the running program, then where an installed program has it, then where the system finds libraries,
/// which the run path of a program that links our libraries may extend. Thread-safe.
///
/// A symbol's name carries the version of what it gives ("patinate_media_3"), so that a module of another build is
/// refused instead of misunderstood.
/// @throws CannotComplete naming the file if it is not there, cannot be loaded, or lacks the symbol.
[[nodiscard]] void* module_function(const std::string& name, const std::string& symbol);

}  // namespace patinate
