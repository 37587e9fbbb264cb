/// \file
/// The keyword `device` of a call.
#pragma once

#include <memory>

#include "app/device/checked_devices.h"
#include "python/support/keywords.h"

namespace patinate::python {

/// Device that calculates, and its messages: a device that fails is a RuntimeWarning of the call, which goes on. Copies
/// are the same.
class DeviceKeyword {
 public:
  /// @throws TypeError
  explicit DeviceKeyword(Keywords& keywords);

  [[nodiscard]] const device::DeviceOptions& options() const { return options_; }
  /// For those that open it, on any thread.
  [[nodiscard]] app::Words words() const;
  /// Says what was noted since, with the interpreter's lock. @throws what the filter of warnings makes of it
  void warn() const;

 private:
  struct Notes;
  device::DeviceOptions options_;
  std::shared_ptr<Notes> notes_;
};

}  // namespace patinate::python
