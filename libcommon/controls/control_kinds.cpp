#include "patinate/controls/control_kinds.h"

#include <algorithm>
#include <utility>

#include "libcommon/controls/control_arguments.h"
#include "libcommon/controls/control_expression.h"
#include "libcommon/controls/distance_io.h"
#include "libcommon/controls/height.h"
#include "libcommon/controls/image_control.h"
#include "libcommon/controls/spray_path_io.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate {

namespace {

using Options = ControlKindOptions;

ControlMap make_exposure(const TexelMap& map, const Options& o, const RunControl& control) {
  if (o.sky.empty()) return exposure_map(map, o.up, o.exposure, o.sun, {}, control);
  const ImageF panorama = read_color(o.sky);
  try {
    return exposure_map(map, o.up, o.exposure, o.sun, panorama, control);
  } catch (const InvalidInput& e) {
    throw IoError(o.sky, e.what());
  }
}

ControlMap make_spray(const TexelMap& map, const Options& o, const RunControl& control) {
  const std::vector<SprayStop> path = o.spray_path.empty()
                                          ? default_spray_path(map.mesh())
                                          : read_spray_path(o.spray_path, bounding_box(map.mesh()).center(), o.spray);
  return spray_map(map, path, o.spray, control);
}

constexpr std::array<std::pair<const char*, DistanceSource::Edges>, 4> kDistanceEdges{
    {{"boundary", DistanceSource::Edges::Boundary},
     {"creases", DistanceSource::Edges::Creases},
     {"ridges", DistanceSource::Edges::Ridges},
     {"valleys", DistanceSource::Edges::Valleys}}};

/// The edges that --distance-from names; None when it names a file. @throws ParseError when it names neither.
DistanceSource::Edges distance_edges(const Options& o) {
  if (o.distance_from.empty()) {
    throw ParseError(
        "the control `distance` needs what it is measured from, as distance(from=creases): boundary, creases, ridges, "
        "valleys, a CSV of curves "
        "or an image");
  }
  std::vector<std::string> names;
  for (const auto& [name, edges] : kDistanceEdges) {
    if (o.distance_from == name) return edges;
    names.emplace_back(name);
  }
  const std::filesystem::path file(o.distance_from);
  if (file.extension().empty() && !std::filesystem::exists(file)) {
    throw ParseError("distance(from=...): found `" + o.distance_from +
                     "`; expected boundary, creases, ridges, valleys, a CSV of curves or an image" +
                     did_you_mean(o.distance_from, names));
  }
  return DistanceSource::Edges::None;
}

ControlMap make_distance(const TexelMap& map, const Options& o, const RunControl& control) {
  DistanceSource source;
  source.edges = distance_edges(o);
  if (source.edges != DistanceSource::Edges::None) return distance_map(map, source, o.distance, control);
  const std::filesystem::path file(o.distance_from);
  if (file.extension() == ".csv") {
    source.curves = read_curves(file);
  } else {
    source.mask = read_control_file(file, map).values;
  }
  try {
    return distance_map(map, source, o.distance, control);
  } catch (const InvalidInput& e) {
    throw IoError(o.distance_from, e.what());
  }
}

ControlMap make_image(const TexelMap& map, const Options& o, const RunControl&) {
  if (o.image.empty()) throw ParseError("the control `image` needs an image, as image(file=\"stain.png\")");
  return read_control_file(o.image, map);
}

struct Entry {
  const char* name;
  const char* brief;
  ControlMap (*make)(const TexelMap&, const Options&, const RunControl&);
  std::string Options::*file;                      ///< File that it reads; may be null.
  void (*take)(Options& to, const Options& from);  ///< Copies what it looks at.
};

const Entry kKinds[] = {
    {"accessibility", "concave places by mean curvature: crevices, corners, folds",
     [](const TexelMap& m, const Options& o, const RunControl& c) { return accessibility_map(m, o.accessibility, c); },
     nullptr, [](Options& t, const Options& f) { t.accessibility = f.accessibility; }},
    {"ray_share", "enclosed places: the share of rays that hit the object again within `reach`",
     [](const TexelMap& m, const Options& o, const RunControl& c) { return ray_share_map(m, o.ray_share, c); }, nullptr,
     [](Options& t, const Options& f) { t.ray_share = f.ray_share; }},
    {"tangent_sphere", "enclosed places: 1 / radius of the largest sphere that touches from outside",
     [](const TexelMap& m, const Options& o, const RunControl& c) {
       return tangent_sphere_map(m, o.tangent_sphere, c);
     },
     nullptr, [](Options& t, const Options& f) { t.tangent_sphere = f.tangent_sphere; }},
    {"exposure", "places that see much of the sky (and of the sun, with `sun_share`)", make_exposure, &Options::sky,
     [](Options& t, const Options& f) { t.up = f.up, t.exposure = f.exposure, t.sun = f.sun, t.sky = f.sky; }},
    {"sun", "where the sun shines, shadows included, at one hour or over an arc of the day",
     [](const TexelMap& m, const Options& o, const RunControl& c) { return sun_map(m, o.up, o.sun, c); }, nullptr,
     [](Options& t, const Options& f) { t.up = f.up, t.sun = f.sun; }},
    {"facing", "surface that faces `direction`; shadows are ignored",
     [](const TexelMap& m, const Options& o, const RunControl& c) { return facing_map(m, o.facing, c); }, nullptr,
     [](Options& t, const Options& f) { t.facing = f.facing; }},
    {"height", "high places along `up`, in mm",
     [](const TexelMap& m, const Options& o, const RunControl& c) { return height_map(m, o.up, c); }, nullptr,
     [](Options& t, const Options& f) { t.up = f.up; }},
    {"distance", "places far from `from`, in mm along the surface; `!distance` is near it", make_distance,
     &Options::distance_from,
     [](Options& t, const Options& f) { t.distance_from = f.distance_from, t.distance = f.distance; }},
    {"spray", "places that get much paint from the nozzle that follows `path`", make_spray, &Options::spray_path,
     [](Options& t, const Options& f) { t.spray = f.spray, t.spray_path = f.spray_path; }},
    {"image", "bright places of an image, `file`, mapped onto the atlas by UV", make_image, &Options::image,
     [](Options& t, const Options& f) { t.image = f.image; }},
};

/// Gives every option another value, allowed or not.
class OptionChanger final : public OptionVisitor {
 public:
  void visit(const OptionInfo&, double& value) override { value += 1.0; }
  void visit(const OptionInfo&, int& value) override { ++value; }
  void visit(const OptionInfo&, std::int64_t& value) override { ++value; }
  void visit(const OptionInfo&, bool& value) override { value = !value; }
  void visit(const OptionInfo&, std::string& value) override { value += "x"; }
  void visit(const OptionInfo&, std::optional<double>& value) override { value = value.value_or(0.0) + 1.0; }
  void visit(const OptionInfo&, std::span<double> values) override { values[0] += 1.0; }
  void visit_choice_index(const OptionInfo&, int& index, std::span<const std::string_view>) override {
    index = index == 0 ? 1 : 0;
  }
};

const Entry* find_kind(const std::string& name) {
  const auto* const found =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Entry& e) { return e.name == name; });
  return found == std::end(kKinds) ? nullptr : found;
}

}  // namespace

void describe(OptionVisitor& v, ControlKindOptions& o) {
  describe(v, o.accessibility);
  describe(v, o.ray_share);
  describe(v, o.tangent_sphere);
  v.visit({"up", "direction that is up for `exposure`, `sun` and `height`", "", {}}, std::span<double>(o.up));
  describe(v, o.exposure);
  v.visit({"sky", "equirectangular panorama that gives the light of `exposure`; not given: an even sky"}, o.sky);
  describe(v, o.sun);
  describe(v, o.facing);
  v.visit({"distance_from",
           "what `distance` is measured from: boundary, creases, ridges (creases that stand out), valleys (sunk in), a "
           "CSV of "
           "points x,y,z in mm (an empty line ends a curve) or an image (>= 0.5 is 0)"},
          o.distance_from);
  describe(v, o.distance);
  describe(v, o.spray);
  v.visit({"spray_path",
           "nozzle stops (CSV of x,y,z[,dwell[,aim_x,aim_y,aim_z]]) or painted strokes (CSV with column names, JSON); "
           "not given: "
           "one stop, up and in front"},
          o.spray_path);
  v.visit({"image", "image of the kind `image`, mapped onto the atlas by UV"}, o.image);
}

const std::vector<ControlKind>& control_kinds() {
  static const std::vector<ControlKind> kinds = [] {
    std::vector<ControlKind> list;
    for (const Entry& e : kKinds) list.push_back({e.name, e.brief});
    return list;
  }();
  return kinds;
}

const std::vector<std::string>& control_kind_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Entry& e : kKinds) list.emplace_back(e.name);
    return list;
  }();
  return names;
}

ControlKindOptions used_options(const std::string& kind, const ControlKindOptions& options) {
  ControlKindOptions used;
  if (const Entry* const entry = find_kind(kind)) entry->take(used, options);
  return used;
}

std::vector<std::string> control_option_names(const std::string& kind) {
  ControlKindOptions changed;
  OptionChanger changer;
  describe(changer, changed);
  const auto before = option_values(ControlKindOptions{}), after = option_values(used_options(kind, changed));
  std::vector<std::string> names;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i].second != after[i].second) names.push_back(before[i].first);
  }
  return names;
}

std::vector<std::filesystem::path> control_input_files(const std::string& kind, const ControlKindOptions& options) {
  const Entry* const entry = find_kind(kind);
  if (entry == nullptr || entry->file == nullptr || (options.*entry->file).empty()) return {};
  if (entry->file == &Options::distance_from && distance_edges(options) != DistanceSource::Edges::None) return {};
  return {options.*entry->file};
}

ControlMap make_control(const std::string& kind, const TexelMap& map, const ControlKindOptions& options,
                        const RunControl& control) {
  check_ranges(options);
  if (const Entry* const entry = find_kind(kind)) {
    ControlMap made = entry->make(map, options, control);
    note_if_even(made, map.coverage(), kind);
    return made;
  }
  std::string list;
  for (const std::string& name : control_kind_names()) list += (list.empty() ? "`" : ", `") + name + "`";
  throw ParseError("unknown kind of control `" + kind + "`; there are " + list +
                   did_you_mean(kind, control_kind_names()));
}

ControlMap read_control_file(const std::filesystem::path& path, const TexelMap& map) {
  std::vector<ImageF> images;
  for (const auto& file : tile_map_files(path, map.sheet().names)) images.push_back(read_gray(file));
  const bool is_alone = images.size() == 1 && map.sheet().num_tiles() == 1;
  try {
    ControlMap made = image_map(map, is_alone ? images.front() : lay_over_tiles(map.sheet(), images));
    note_if_even(made, map.coverage(), path.filename().string());
    return made;
  } catch (const InvalidInput& e) {
    throw IoError(path.string(), e.what());
  }
}

ControlMap make_control_expression(std::string_view expression, const TexelMap& map, const ControlKindOptions& options,
                                   const RunControl& control, const ControlSource& source) {
  const ControlExpression parsed(expression, control_kind_names());
  const auto count = static_cast<double>(parsed.names().size());
  double done = 0.0;
  ControlMap out = parsed.evaluate(map.coverage(), [&](const ControlName& name) {
    const RunControl part = control.part(done / count, (done + 1.0) / count);
    done += 1.0;
    if (name.is_file) return read_control_file(name.text, map);
    const ControlKindOptions named = named_options(name, options);
    return source ? source(name.text, map, named, part) : make_control(name.text, map, named, part);
  });
  out.has_file =
      std::any_of(parsed.names().begin(), parsed.names().end(), [](const ControlName& n) { return n.is_file; });
  if (out.notes.empty()) note_if_even(out, map.coverage(), std::string(expression));
  control.report(1.0);
  return out;
}

}  // namespace patinate
