/// \file
/// Arguments that are given by name: described options, single values, and how a long call is run.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate::python {

/// How a long call is watched.
struct RunArguments {
  pybind11::object progress = pybind11::none();  ///< None, or called with a fraction.
  pybind11::object close = pybind11::none();     ///< None, or called when the work is over, however it ended.
  int num_threads = 0;
};

/// The keywords of one call; each is taken once, and finish() refuses what is left.
class Keywords {
 public:
  Keywords(std::string function, const pybind11::kwargs& given);

  /// Fields that are given get these values. @throws InvalidInput where one is out of range; TypeError.
  template <class Options>
  void read(Options& options) {
    Described<Options> described(options);
    read_described(described);
  }
  /// Whether it is given and was not taken yet.
  [[nodiscard]] bool is_given(const std::string& name) const { return left_.contains(name.c_str()); }
  /// None when it is not given.
  [[nodiscard]] pybind11::object object(const std::string& name);
  [[nodiscard]] std::string text(const std::string& name, const std::string& otherwise);
  [[nodiscard]] std::optional<double> number(const std::string& name);
  [[nodiscard]] std::int64_t integer(const std::string& name, std::int64_t otherwise);
  [[nodiscard]] bool flag(const std::string& name, bool otherwise);
  /// `on_progress` and `num_threads`.
  [[nodiscard]] RunArguments run();
  /// @throws TypeError naming the first that nobody took, with a did-you-mean.
  void finish() const;

 private:
  void read_described(DescribedOptions& options);

  std::string function_;
  pybind11::dict left_;
  std::vector<std::string> known_;
};

/// "fit(): vary: found str; expected a dict". @throws TypeError
[[noreturn]] void wrong_type(const std::string& function, const std::string& name, const pybind11::handle& found,
                             const std::string& expected);
/// A path or text as Python has it, by os.fspath(). @throws TypeError
[[nodiscard]] std::string path_from(const pybind11::object& path);

/// Runs `work` without the interpreter's lock, on a thread of its own. Meanwhile this one calls `on_progress`, and
/// stops the work when that raises, or on Ctrl-C. It looks every 10 ms; what has not stopped 25 ms later is left
/// behind: its result is dropped, and the next call waits for its end. So nothing may be captured by reference.
void run_interruptibly(const RunArguments& arguments, std::function<void(const RunControl&)> work);
/// Works in the same way for work that has a result.
template <class F>
[[nodiscard]] auto result_of(const RunArguments& arguments, F work) {
  struct Held {
    F work;
    std::optional<decltype(work(RunControl{}))> result = std::nullopt;
  };
  const auto held = std::make_shared<Held>(Held{std::move(work)});
  run_interruptibly(arguments, [held](const RunControl& control) { held->result.emplace(held->work(control)); });
  return std::move(*held->result);
}
/// For work that uses what its caller holds, such as Python's own functions: Ctrl-C waits until it has stopped.
void run_borrowing(const RunArguments& arguments, const std::function<void(const RunControl&)>& work);
/// Waits for what was left behind, if anything. @throws KeyboardInterrupt
void finish_left_work();

}  // namespace patinate::python
