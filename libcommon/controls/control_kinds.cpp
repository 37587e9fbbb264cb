#include "libcommon/controls/control_kinds.h"

#include <algorithm>

#include "libcommon/controls/control_expression.h"
#include "libcommon/controls/image_control.h"
#include "libcommon/controls/spray_path_io.h"
#include "libcommon/core/error.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_io.h"

namespace patinate {

void describe(OptionVisitor& v, ControlKindOptions& o) {
  describe(v, o.accessibility);
  describe(v, o.facing);
  describe(v, o.spray);
  v.visit(
      {"spray_path", "CSV of nozzle stops: x,y,z[,dwell[,aim_x,aim_y,aim_z]]; not given: one stop, up and in front"},
      o.spray_path);
  v.visit({"image", "image of the kind `image`, laid over the atlas by UV"}, o.image);
}

const std::vector<std::string>& control_kind_names() {
  static const std::vector<std::string> names{"accessibility", "facing", "spray", "image"};
  return names;
}

std::vector<std::filesystem::path> control_input_files(const std::string& kind, const ControlKindOptions& options) {
  if (kind == "spray" && !options.spray_path.empty()) return {options.spray_path};
  if (kind == "image" && !options.image.empty()) return {options.image};
  return {};
}

ControlMap make_control(const std::string& kind, const TexelMap& map, const ControlKindOptions& options,
                        const RunControl& control) {
  check_ranges(options);
  if (kind == "accessibility") return accessibility_map(map, options.accessibility, control);
  if (kind == "facing") return facing_map(map, options.facing, control);
  if (kind == "spray") {
    const std::vector<SprayStop> path = options.spray_path.empty()
                                            ? default_spray_path(map.mesh())
                                            : read_spray_path(options.spray_path, bounding_box(map.mesh()).center());
    return spray_map(map, path, options.spray, control);
  }
  if (kind == "image") {
    if (options.image.empty()) throw UsageError("the control `image` needs an image; use --image FILE");
    return read_control_file(options.image, map);
  }
  std::string list;
  for (const std::string& name : control_kind_names()) list += (list.empty() ? "`" : ", `") + name + "`";
  throw UsageError("unknown kind of control `" + kind + "`" + did_you_mean(kind, control_kind_names()) +
                   "; there are " + list);
}

ControlMap read_control_file(const std::filesystem::path& path, const TexelMap& map) {
  const ImageF image = read_gray(path);
  try {
    return image_map(map, image);
  } catch (const IoError&) {
    throw;
  } catch (const InvalidInput& e) {
    throw IoError(path.string(), e.what());
  }
}

ControlMap make_control_expression(std::string_view expression, const TexelMap& map, const ControlKindOptions& options,
                                   const RunControl& control) {
  const ControlExpression parsed(expression, control_kind_names());
  const auto count = static_cast<double>(parsed.names().size());
  double done = 0.0;
  ControlMap out = parsed.evaluate(map.coverage(), [&](const ControlName& name) {
    const RunControl part = control.part(done / count, (done + 1.0) / count);
    done += 1.0;
    return name.is_file ? read_control_file(name.text, map) : make_control(name.text, map, options, part);
  });
  control.report(1.0);
  return out;
}

}  // namespace patinate
