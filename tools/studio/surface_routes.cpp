// Color over time: /api/texture, /api/map, /api/curve, /api/paint, /api/mesh, /api/plants.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/image/picture_bytes.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/image/color.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/simulation/scene_io.h"
#include "tools/studio/mesh_glb.h"
#include "tools/studio/plane_hash.h"
#include "tools/studio/plant_rows.h"
#include "tools/studio/registered_scans.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

namespace {

constexpr int kMostSide = 65536;
constexpr double kMaxTime = 1e18;

/// Choice from a list; its first where nothing is asked for.
std::size_t chosen(const Asked& asked, const std::string& what, std::span<const std::string_view> names) {
  if (!asked.target.has(what)) return 0;
  const std::string name = asked.target.value(what);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    std::string known;
    for (const std::string_view n : names) known += (known.empty() ? "" : ", ") + std::string(n);
    throw InvalidInput(what + ": found \"" + name + "\"; expected one of " + known);
  }
  return static_cast<std::size_t>(found - names.begin());
}

/// [0, 1] as they are, for what is no color.
ImageU8 linear_codes(const ImageF& image) {
  ImageU8 codes(image.width(), image.height(), image.channels());
  std::transform(image.values().begin(), image.values().end(), codes.data(),
                 [](float v) { return static_cast<std::uint8_t>(255.0f * std::clamp(v, 0.0f, 1.0f) + 0.5f); });
  return codes;
}

/// Longest side at most as the request says.
ImageF sized(ImageF image, const Asked& asked) {
  if (!asked.target.has("size")) return image;
  const int size = asked.integer("size", 1, kMostSide);
  const int longest = std::max(image.width(), image.height());
  if (size >= longest) return image;
  const auto side = [&](int s) {
    return static_cast<int>(std::max<std::int64_t>(1, (std::int64_t{s} * size + longest / 2) / longest));
  };
  return downscale_area(image, side(image.width()), side(image.height()), asked.control);
}

std::string rgba_rows(const ImageU8& rgb) {
  std::string bytes(static_cast<std::size_t>(rgb.num_pixels()) * 4, '\xFF');
  for (std::int64_t i = 0; i < rgb.num_pixels(); ++i) std::copy_n(rgb.data() + 3 * i, 3, bytes.data() + 4 * i);
  return bytes;
}

HttpResponse sized_response(std::string type, std::string body, int width, int height) {
  return {.type = std::move(type),
          .headers = {{"X-Width", std::to_string(width)}, {"X-Height", std::to_string(height)}},
          .body = std::move(body)};
}

}  // namespace

HttpResponse answer_texture(const Asked& asked) {
  const std::string format = asked.target.has("format") ? asked.target.value("format") : "raw";
  if (format != "raw" && format != "png") throw InvalidInput("format: found \"" + format + "\"; expected raw or png");
  const double time = asked.number("time", -kMaxTime, kMaxTime);
  const auto between = static_cast<Between>(chosen(asked, "between", kBetweenNames));
  const std::optional<int> tile =
      asked.target.has("tile") ? std::optional(asked.integer("tile", 0, 1'000'000)) : std::nullopt;
  const std::shared_ptr<const SurfaceInTime> surface = asked.surface();
  const auto map = static_cast<SurfaceMap>(chosen(asked, "map", kSurfaceMapNames));
  const ImageF texture = sized(surface->texture(map, time, between, tile, asked.control), asked);
  const ImageU8 codes = map == SurfaceMap::Orm ? linear_codes(texture) : srgb8_from_linear(texture);
  asked.control.throw_if_stopped();
  std::string rows = rgba_rows(codes);
  const std::string hash = xxh64(rows);
  HttpResponse response =
      format == "png" ? sized_response("image/png", png_of(codes), codes.width(), codes.height())
                      : sized_response("application/octet-stream", std::move(rows), codes.width(), codes.height());
  response.headers.emplace_back("X-Hash", hash);
  return response;
}

HttpResponse answer_map(const Asked& asked) {
  const std::string name = asked.target.value("name");
  const double time = asked.target.has("time") ? asked.number("time", -kMaxTime, kMaxTime) : 0.0;
  NamedMap map = asked.surface()->map(name, time);
  if (name != "coordinates")
    map.values = sized(std::move(map.values), asked);  // means of coordinates are no coordinates
  const ImageF& image = map.values;
  HttpResponse response = sized_response(
      "application/octet-stream", {reinterpret_cast<const char*>(image.data()), image.values().size() * sizeof(float)},
      image.width(), image.height());
  response.headers.emplace_back("X-Channels", std::to_string(image.channels()));
  response.headers.emplace_back("X-Low", number_text(map.low));
  response.headers.emplace_back("X-High", number_text(map.high));
  response.headers.emplace_back("X-Unit", map.unit);
  return response;
}

HttpResponse answer_curve(const Asked& asked) {
  const int x = asked.integer("x", 0, kMostSide), y = asked.integer("y", 0, kMostSide);
  const std::shared_ptr<const SurfaceInTime> surface = asked.surface();
  const TexelCurve curve = surface->curve(x, y, asked.control);
  Json json{{"times", curve.times}, {"srgb", curve.srgb}, {"lab", curve.lab}};
  json["values"] = json["constants"] = Json::array();
  for (const ValueCurve& v : curve.values) {
    Json values = Json::array();
    for (const std::optional<double>& value : v.values) values.push_back(value ? Json(*value) : Json(nullptr));
    json["values"].push_back({{"name", v.name}, {"unit", v.unit}, {"values", std::move(values)}});
  }
  for (const TexelValue& v : curve.constants)
    json["constants"].push_back({{"name", v.name}, {"unit", v.unit}, {"value", v.value}});
  if (curve.source) {
    json["source"] = nullptr;
    if ((*curve.source)[0] >= 0) {
      std::error_code error;
      const std::filesystem::path history = std::filesystem::canonical(surface->history().folder(), error);
      const std::string name = error ? "" : asked.folder.name_of(history);
      const bool is_served = !name.empty() && asked.folder.find(name).has_value();
      json["source"] = {
          {"place", is_served ? Json(name) : Json(nullptr)}, {"x", (*curve.source)[0]}, {"y", (*curve.source)[1]}};
    }
  }
  return json_response(json);
}

HttpResponse paint_transfer(const Asked& asked, const std::string& body) {
  const auto [path, kind] = asked.place();
  if (kind != PlaceKind::Transfer)
    throw InvalidInput("only transfers are painted; this place is a " +
                       std::string(kPlaceKindNames[static_cast<std::size_t>(kind)]));
  const PaintRequest request = parse_paint_request(body);
  return {.type = "application/octet-stream",
          .body = asked.painted.open(asked.folder, path, asked.control)->answer(request, asked.control)};
}

namespace {

/// The mesh of a place, where its objects are now, and meters per unit of it.
std::pair<PartedMesh, double> shown_mesh(const Asked& asked, const std::filesystem::path& path, PlaceKind kind) {
  constexpr double kMeters = 0.001;
  const std::string name = path.stem().string();
  if (const std::shared_ptr<LiveScene> scene = asked.live.find(path); scene && scene->problem().empty())
    return {scene->parted_mesh(), kMeters};
  if (kind == PlaceKind::Mesh)
    return {parted_mesh(with_normals(read_mesh(path)), name), is_gltf_file(path) ? 1.0 : kMeters};
  if (kind == PlaceKind::Scene) return {parted_mesh(simulation::read_scene(path, asked.control).scene), kMeters};
  return {parted_mesh(asked.opened.open(path, kind)->mesh(), name), kMeters};
}

}  // namespace

HttpResponse answer_mesh(const Asked& asked) {
  const auto [path, kind] = asked.place();
  std::string glb;
  if (kind == PlaceKind::Registration) {
    glb = registered_scans_glb(read_registration(path, asked.folder), asked.control);
  } else {
    auto [mesh, meters] = shown_mesh(asked, path, kind);
    if (asked.target.has("texels")) mesh = cut_to_texels(std::move(mesh), asked.integer("texels", 1, kMostSide));
    glb = mesh_glb(mesh, meters);
  }
  return {.type = "model/gltf-binary", .body = std::move(glb)};
}

HttpResponse answer_plants(const Asked& asked) {
  const auto [path, kind] = asked.place();
  if (kind != PlaceKind::Scene && kind != PlaceKind::Simulation)
    throw InvalidInput("only scenes and simulations have plants");
  const PartedMesh mesh = shown_mesh(asked, path, kind).first;
  return {.type = "application/octet-stream", .body = plant_rows(mesh)};
}

}  // namespace patinate::studio
