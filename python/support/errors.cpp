#include "python/support/errors.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <string>

#include "app/request/usage_error.h"
#include "patinate/core/error.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

enum Kind { kError, kInputError, kInvalidInput, kParseError, kIoError, kCannotComplete, kCanceled, kNumKinds };
/// Borrowed by the translator for as long as the interpreter lives.
std::array<PyObject*, kNumKinds> types{};

void add(py::module_& module, Kind kind, const char* name, const char* doc, py::tuple bases, const char* base_names) {
  PyObject* type = PyErr_NewExceptionWithDoc(("patinate." + std::string(name)).c_str(), doc, bases.ptr(), nullptr);
  if (type == nullptr) throw py::error_already_set();
  types[kind] = type;
  module.add_object(name, type);
  add_stub("class " + std::string(name) + "(" + base_names + "):\n    \"\"\"" + doc + "\"\"\"\n");
}

py::tuple bases_of(std::initializer_list<PyObject*> list) {
  py::tuple out(list.size());
  std::size_t i = 0;
  for (PyObject* base : list) out[i++] = py::reinterpret_borrow<py::object>(base);
  return out;
}

void translate(std::exception_ptr pointer) {
  const auto raise = [](Kind kind, const std::exception& e) {
    const std::string words = with_keywords(e.what());
    const auto text =
        py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(words.c_str()));  // It may name a file.
    if (text) PyErr_SetObject(types[kind], text.ptr());
  };
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const InvalidInput& e) {
    raise(kInvalidInput, e);
  } catch (const app::UsageError& e) {  // Arguments that do not go together, as the command line says it.
    raise(kInvalidInput, e);
  } catch (const ParseError& e) {
    raise(kParseError, e);
  } catch (const IoError& e) {
    raise(kIoError, e);
  } catch (const InputError& e) {
    raise(kInputError, e);
  } catch (const CannotComplete& e) {
    raise(kCannotComplete, e);
  } catch (const Canceled& e) {
    raise(kCanceled, e);
  } catch (const Error& e) {
    raise(kError, e);
  } catch (const std::filesystem::filesystem_error& e) {
    raise(kCannotComplete, e);
  } catch (const py::cast_error& e) {  // A value of the user's that is not what is expected there.
    PyErr_SetString(PyExc_TypeError, e.what());
  }
}

}  // namespace

std::string with_keywords(const std::string& text) {
  static const std::regex option("(^|[\\s`(])--([a-z][a-z0-9-]*)");
  std::string out;
  std::size_t end = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), option), none; it != none; ++it) {
    const std::smatch& found = *it;
    std::string name = found[2];
    std::replace(name.begin(), name.end(), '-', '_');
    out += text.substr(end, static_cast<std::size_t>(found.position()) - end) + found[1].str() + name;
    if (name == "force") out += "=True";
    end = static_cast<std::size_t>(found.position() + found.length());
  }
  out += text.substr(end);
  return out.starts_with("-o: ") ? "output" + out.substr(2) : out;
}

void warn_of(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) {
    if (PyErr_WarnEx(PyExc_UserWarning, with_keywords(note).c_str(), 1) != 0) throw py::error_already_set();
  }
}

void bind_errors(py::module_& module) {
  add(module, kError, "Error", "Base of all errors of patinate: one line that says what is wrong.",
      bases_of({PyExc_Exception}), "Exception");
  add(module, kInputError, "InputError", "What was given is wrong.", bases_of({types[kError], PyExc_ValueError}),
      "Error, ValueError");
  add(module, kInvalidInput, "InvalidInput", "A precondition on data or an option is broken.",
      bases_of({types[kInputError]}), "InputError");
  add(module, kParseError, "ParseError", "A text cannot be understood: an expression, a control, a range.",
      bases_of({types[kInputError]}), "InputError");
  add(module, kIoError, "IoError", "A file cannot be read or does not hold what it should.",
      bases_of({types[kInputError], PyExc_OSError}), "InputError, OSError");
  add(module, kCannotComplete, "CannotComplete", "Valid work that could not be done: disk full, another output there.",
      bases_of({types[kError]}), "Error");
  add(module, kCanceled, "Canceled", "The caller asked to stop; nothing half-written is left.",
      bases_of({types[kError]}), "Error");
  py::register_local_exception_translator(translate);  // Other modules' casts are their own.
}

}  // namespace patinate::python
