#include "python/support/keywords.h"

#include <span>
#include <string_view>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

std::string type_name(const py::handle& value) { return py::str(py::type::handle_of(value).attr("__name__")); }

bool is_bool(const py::handle& value) {
  return PyBool_Check(value.ptr()) != 0 || type_name(value) == "bool_";  // numpy's.
}

double number_of(const std::string& function, const std::string& name, const py::handle& value) {
  if (is_bool(value) || PyNumber_Check(value.ptr()) == 0) wrong_type(function, name, value, "a number");
  const double number = PyFloat_AsDouble(value.ptr());
  if (number == -1.0 && PyErr_Occurred() != nullptr) throw py::error_already_set();
  return number;
}

std::int64_t integer_of(const std::string& function, const std::string& name, const py::handle& value) {
  if (is_bool(value) || PyIndex_Check(value.ptr()) == 0) wrong_type(function, name, value, "an integer");
  const py::object index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!index) throw py::error_already_set();
  const std::int64_t number = PyLong_AsLongLong(index.ptr());
  if (number == -1 && PyErr_Occurred() != nullptr) throw py::error_already_set();
  return number;
}

bool flag_of(const std::string& function, const std::string& name, const py::handle& value) {
  if (!is_bool(value)) wrong_type(function, name, value, "True or False");
  return py::cast<bool>(value);
}

std::string text_of(const std::string& function, const std::string& name, const py::handle& value) {
  if (!py::isinstance<py::str>(value) && !py::hasattr(value, "__fspath__"))
    wrong_type(function, name, value, "a text or path");
  return path_from(py::reinterpret_borrow<py::object>(value));
}

/// Takes what is given out of a dict.
class Reader final : public OptionVisitor {
 public:
  Reader(const std::string& function, py::dict& left, std::vector<std::string>& known)
      : function_(function), left_(left), known_(known) {}

  void visit(const OptionInfo& info, double& value) override {
    if (const py::object o = take(info)) value = number_of(function_, name_, o);
  }
  void visit(const OptionInfo& info, int& value) override {
    const py::object o = take(info);
    if (!o) return;
    const std::int64_t number = integer_of(function_, name_, o);
    value = static_cast<int>(number);
    if (value != number) throw InvalidInput(name_ + ": " + std::to_string(number) + " is out of range");
  }
  void visit(const OptionInfo& info, std::int64_t& value) override {
    if (const py::object o = take(info)) value = integer_of(function_, name_, o);
  }
  void visit(const OptionInfo& info, bool& value) override {
    if (const py::object o = take(info)) value = flag_of(function_, name_, o);
  }
  void visit(const OptionInfo& info, std::string& value) override {
    if (const py::object o = take(info)) value = text_of(function_, name_, o);
  }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    const py::object o = take(info);
    if (o) value = o.is_none() ? std::nullopt : std::optional(number_of(function_, name_, o));
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    const py::object o = take(info);
    if (!o) return;
    const std::string expected = std::to_string(values.size()) + " numbers";
    if (!py::isinstance<py::sequence>(o) || py::len(o) != values.size()) wrong_type(function_, name_, o, expected);
    std::size_t i = 0;
    for (const py::handle item : o) values[i++] = number_of(function_, name_, item);
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    const py::object o = take(info);
    if (!o) return;
    const std::string word = text_of(function_, name_, o);
    const std::vector<std::string> all(names.begin(), names.end());
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i] == word) {
        index = static_cast<int>(i);
        return;
      }
    }
    std::string list;
    for (const std::string& name : all) list += (list.empty() ? "" : ", ") + name;
    throw InvalidInput(name_ + ": found `" + word + "`; expected " + list + did_you_mean(word, all));
  }

 private:
  /// Empty when it is not given.
  py::object take(const OptionInfo& info) {
    name_ = info.name;
    known_.push_back(name_);
    if (!left_.contains(name_)) return {};
    py::object value = left_[name_.c_str()];
    left_.attr("pop")(name_);
    return value;
  }

  const std::string& function_;
  py::dict& left_;
  std::vector<std::string>& known_;
  std::string name_;
};

}  // namespace

void wrong_type(const std::string& function, const std::string& name, const py::handle& found,
                const std::string& expected) {
  throw py::type_error(function + "(): " + name + ": found " + type_name(found) + "; expected " + expected);
}

std::string path_from(const py::object& path) {
  const py::bytes name = py::module_::import("os").attr("fsencode")(path);  // Not all names are UTF-8.
  return std::string(name);
}

Keywords::Keywords(std::string function, const py::kwargs& given) : function_(std::move(function)) {
  for (const auto& [name, value] : given) left_[name] = value;
}

void Keywords::read_described(DescribedOptions& options) {
  Reader reader(function_, left_, known_);
  options.accept(reader);
  check_ranges(options);
}

py::object Keywords::object(const std::string& name) {
  known_.push_back(name);
  return left_.contains(name) ? py::object(left_.attr("pop")(name)) : py::none();
}

std::string Keywords::text(const std::string& name, const std::string& otherwise) {
  const py::object o = object(name);
  return o.is_none() ? otherwise : text_of(function_, name, o);
}

std::optional<double> Keywords::number(const std::string& name) {
  const py::object o = object(name);
  return o.is_none() ? std::nullopt : std::optional(number_of(function_, name, o));
}

std::int64_t Keywords::integer(const std::string& name, std::int64_t otherwise) {
  const py::object o = object(name);
  return o.is_none() ? otherwise : integer_of(function_, name, o);
}

bool Keywords::flag(const std::string& name, bool otherwise) {
  const py::object o = object(name);
  return o.is_none() ? otherwise : flag_of(function_, name, o);
}

RunArguments Keywords::run() {
  RunArguments run;
  const std::int64_t num_threads = integer("num_threads", 0);
  constexpr int kMaxThreads = 4096;
  if (num_threads < 0 || num_threads > kMaxThreads)
    throw InvalidInput("num_threads: " + std::to_string(num_threads) + " is out of range; use [0, 4096]");
  run.num_threads = static_cast<int>(num_threads);
  run.progress = object("on_progress");
  if (run.progress.is_none() || PyCallable_Check(run.progress.ptr()) != 0) return run;
  const bool wants_bar = flag_of(function_, "on_progress", run.progress);
  run.progress = wants_bar ? py::module_::import("patinate._progress").attr("bar")(function_) : py::none();
  if (!run.progress.is_none()) run.close = run.progress.attr("close");
  return run;
}

void Keywords::finish() const {
  for (const auto& item : left_) {
    const std::string name = py::cast<std::string>(item.first);
    throw py::type_error(function_ + "(): has no keyword `" + name + "`" + did_you_mean(name, known_));
  }
}

}  // namespace patinate::python
