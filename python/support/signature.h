/// \file
/// What a function of the module says of itself, once: its docstring with a signature that inspect reads, and its line
/// in the type stubs. Options come from their describe(), so that names, defaults, units and ranges stand nowhere
/// twice.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "patinate/core/options.h"

namespace patinate::python {

/// A parameter as people read it.
struct ParameterText {
  std::string name;
  std::string type;           ///< Type as in stubs: "float", "Callable[[float], None] | None".
  std::string help;           ///< With unit and range.
  std::string default_value;  ///< Default value as Python writes it; "" = must be given.
};
/// Texts of described options, with the values that they have.
[[nodiscard]] std::vector<ParameterText> parameter_texts(DescribedOptions& options);

/// Entries as the module's Report.
[[nodiscard]] pybind11::object report_of(const pybind11::dict& found);

/// Text of the stubs so far, and more of it.
[[nodiscard]] const std::string& stubs();
void add_stub(const std::string& text);
/// Stub of each of several classes, followed by their members, so that a function may name those that come later.
void begin_class_stub(const std::string& name, const std::string& doc);

/// Everything that is said of a function.
class FunctionText {
 public:
  /// @param brief  Sentences; the first is the shortest answer to "what does it do".
  FunctionText(std::string name, std::string brief) : name_(std::move(name)), brief_(std::move(brief)) {}

  /// A parameter that is given by place or name. @param default_value  "None", of the last ones; "" = it must be given.
  FunctionText& takes(std::string name, std::string type, std::string help, std::string default_value = "");
  /// One that is given by name alone.
  FunctionText& keyword(std::string name, std::string type, std::string default_value, std::string help);
  /// Those of an options struct.
  template <class Options>
  FunctionText& options(Options values = {}) {
    Described<Options> described(values);
    return add_options(described);
  }
  /// `on_progress` and `num_threads`, of what can pass a second.
  FunctionText& runs();
  FunctionText& returns(std::string type, std::string help = "");
  FunctionText& raises(std::string text);
  /// Said of a method.
  FunctionText& of_class() {
    is_method_ = true;
    return *this;
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& positional(std::size_t i) const { return positional_.at(i).name; }
  [[nodiscard]] std::size_t num_positional() const { return positional_.size(); }
  [[nodiscard]] std::string docstring() const;
  [[nodiscard]] std::string stub() const;

 private:
  FunctionText& add_options(DescribedOptions& options);

  std::string name_, brief_;
  std::vector<ParameterText> positional_, keywords_;
  std::string return_type_ = "None", return_help_, raises_;
  bool is_method_ = false;
};

namespace detail {

template <class F>
struct Parameters : Parameters<decltype(&F::operator())> {};
template <class R, class C, class... A>
struct Parameters<R (C::*)(A...) const> {
  template <class T>
  static constexpr bool is_keywords = std::is_same_v<std::decay_t<T>, pybind11::kwargs>;
  static constexpr std::size_t kKeywords = (std::size_t{0} + ... + (is_keywords<A> ? 1 : 0));
  static constexpr std::size_t kPositional = sizeof...(A) - kKeywords;

  /// Returns a Report for what returns a dict.
  template <class F>
  static auto reporting(F function) {
    if constexpr (std::is_same_v<R, pybind11::dict>)
      return [function](A... arguments) { return report_of(function(std::forward<A>(arguments)...)); };
    else
      return function;
  }
};

template <class Owner, class F, std::size_t... I>
void define(Owner& owner, const FunctionText& text, F&& function, std::index_sequence<I...>) {
  owner.def(text.name().c_str(), std::forward<F>(function), text.docstring().c_str(),
            pybind11::arg(text.positional(I).c_str())...);
}

}  // namespace detail

/// A function of the module: `function` takes what the text says must be given and, where it says more, kwargs last.
template <class F>
void define(pybind11::module_& module, const FunctionText& text, F&& function) {
  add_stub(text.stub());
  detail::define(module, text, detail::Parameters<std::decay_t<F>>::reporting(std::forward<F>(function)),
                 std::make_index_sequence<detail::Parameters<std::decay_t<F>>::kPositional>());
}
/// A method: the same, with the object first.
template <class Class, class F>
void define_method(Class& type, FunctionText text, F&& function) {
  add_stub(text.of_class().stub());
  detail::define(type, text, std::forward<F>(function),
                 std::make_index_sequence<detail::Parameters<std::decay_t<F>>::kPositional - 1>());
}
/// An attribute that cannot be set.
template <class Class, class F>
void define_property(Class& type, const std::string& name, const std::string& python_type, const std::string& doc,
                     F&& function) {
  type.def_property_readonly(name.c_str(), std::forward<F>(function), doc.c_str());
  add_stub("    @property\n    def " + name + "(self) -> " + python_type + ":\n        \"\"\"" + doc + "\"\"\"\n");
}

}  // namespace patinate::python
