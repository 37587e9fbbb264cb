#include "libcommon/core/module.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>

#include "libcommon/core/programs.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// A bare name, which the loader looks up, when it lies in none of our places.
std::string find_module(const std::string& file) {
  const char* given = std::getenv("PATINATE_MODULES");
  if (given != nullptr && *given != '\0') return fs::absolute(given) / file;
  const fs::path program = programs_folder();
  if (program.empty()) return file;
  std::error_code error;
  for (const fs::path& folder : {program, program / PATINATE_MODULES_FROM_PROGRAMS}) {
    if (fs::exists(folder / file, error)) return (folder / file).lexically_normal();
  }
  return file;
}

/// Why the last call of the loader failed, on one line.
std::string loader_problem(const std::string& file) {
  const char* text = ::dlerror();
  std::string problem = text == nullptr ? "unknown" : text;
  if (problem.starts_with(file + ": ")) problem.erase(0, file.size() + 2);
  return problem.substr(0, problem.find('\n'));
}

void* load(const std::string& file) {
  // RTLD_LOCAL: what a module's libraries define is no business of the program's other libraries.
  void* module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module != nullptr) return module;
  throw CannotComplete(file + ": cannot be loaded (" + loader_problem(file) + "); what helps: Debian's package " +
                       fs::path(file).stem().string() + ", or a build of patinate, which puts it beside the program");
}

}  // namespace

void* module_function(const std::string& name, const std::string& symbol) {
  struct Module {
    std::string file;
    void* handle = nullptr;
  };
  static std::mutex mutex;
  static std::map<std::string, Module> modules;
  const std::lock_guard lock(mutex);
  Module& module = modules[name];
  if (module.handle == nullptr) {
    module.file = find_module(name + ".so");
    module.handle = load(module.file);
  }
  void* function = ::dlsym(module.handle, symbol.c_str());
  if (function == nullptr) {
    throw CannotComplete(module.file + ": is of another version than this program; install both together");
  }
  return function;
}

}  // namespace patinate
