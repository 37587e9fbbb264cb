#include "python/support/device_keyword.h"

#include <mutex>
#include <string>
#include <vector>

namespace patinate::python {

namespace py = pybind11;

struct DeviceKeyword::Notes {
  std::mutex mutex;
  std::vector<std::string> texts;
};

DeviceKeyword::DeviceKeyword(Keywords& keywords) : notes_(std::make_shared<Notes>()) { keywords.read(options_); }

app::Words DeviceKeyword::words() const {
  return {.warning = [notes = notes_](const std::string& text) {
    const std::lock_guard lock(notes->mutex);
    notes->texts.push_back(text);
  }};
}

void DeviceKeyword::warn() const {
  std::vector<std::string> texts;
  {
    const std::lock_guard lock(notes_->mutex);
    texts.swap(notes_->texts);
  }
  for (const std::string& text : texts) {
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }
}

}  // namespace patinate::python
