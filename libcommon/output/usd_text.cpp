#include "libcommon/output/usd_text.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/output/model_origin.h"

namespace patinate {

namespace {

/// A name that a prim may have, unlike those before.
std::string prim_name(const std::string& name, std::set<std::string>& taken) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (out.empty() || std::isdigit(static_cast<unsigned char>(out.front())) != 0) out.insert(0, "_");
  std::string unlike = out;
  for (int i = 2; !taken.insert(unlike).second; ++i) unlike = out + "_" + std::to_string(i);
  return unlike;
}

std::string quoted_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

std::string asset(const std::string& file) {
  return file.find('@') == std::string::npos ? "@" + file + "@" : "control.silent()@" + file + "control.silent()@";
}

/// Single precision, as points are kept.
std::string real(double value) { return number_text(rounded(static_cast<double>(static_cast<float>(value)), 9)); }

/// "(x, y, z)"
template <class V>
std::string tuple(const V& v) {
  std::string out = "(";
  for (Eigen::Index i = 0; i < v.size(); ++i) out += (i == 0 ? "" : ", ") + real(v[i]);
  return out + ")";
}

/// [a, b, ...] of `count` entries.
template <class Entry>
std::string list(std::size_t count, const Entry& entry) {
  std::string out = "[";
  for (std::size_t i = 0; i < count; ++i) out += (i == 0 ? "" : ", ") + entry(i);
  return out + "]";
}

/// { time: value, ... }, on one line, and without a comma at the end: readers that take lines apart take it for a part
/// of the value.
template <class Value>
std::string samples_text(const std::vector<double>& times, const Value& value) {
  std::string out = "{ ";
  for (std::size_t i = 0; i < times.size(); ++i) out += (i == 0 ? "" : ", ") + number_text(times[i]) + ": " + value(i);
  return out + " }";
}

/// Triangles of one object.
struct Part {
  std::string name;
  std::vector<std::size_t> triangles;
};

std::vector<Part> parts_of(const Mesh& mesh, const UsdOptions& options) {
  std::vector<Part> parts;
  for (const std::string& name : options.objects.names) parts.push_back({name, {}});
  if (parts.empty()) parts.push_back({"mesh", {}});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto object = options.objects.triangle_object.empty()
                            ? std::size_t{0}
                            : static_cast<std::size_t>(options.objects.triangle_object[t]);
    parts[object].triangles.push_back(t);
  }
  return parts;
}

/// Those that have triangles, with the names of their prims.
std::vector<std::pair<Part, std::string>> named_parts(const Mesh& mesh, const UsdOptions& options) {
  std::set<std::string> taken{"Materials"};
  std::vector<std::pair<Part, std::string>> named;
  for (Part& part : parts_of(mesh, options)) {
    if (part.triangles.empty()) continue;
    std::string name = prim_name(part.name, taken);
    named.emplace_back(std::move(part), std::move(name));
  }
  return named;
}

std::string root_name(const UsdOptions& options) {
  std::set<std::string> none;
  return prim_name(options.name, none);
}

/// Names of the subsets of faces that show a tile, one a tile.
std::vector<std::string> subset_names(const GlbTiles& tiles) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (const std::string& tile : tiles.names) names.push_back(prim_name("tile_" + tile, taken));
  return names;
}

/// Indices of a part's corners into a list of its own.
struct Compact {
  std::vector<int> entries;  ///< Entries of the mesh's list.
  std::vector<int> corners;  ///< Into entries.
};

Compact compact(const std::vector<Triangle>& triangles, const Part& part, std::size_t size) {
  Compact out;
  std::vector<int> place(size, -1);
  for (const std::size_t t : part.triangles) {
    for (const int entry : triangles[t]) {
      int& at = place[entry];
      if (at < 0) {
        at = static_cast<int>(out.entries.size());
        out.entries.push_back(entry);
      }
      out.corners.push_back(at);
    }
  }
  return out;
}

std::string indices(const std::vector<int>& values) {
  return list(values.size(), [&](std::size_t i) { return std::to_string(values[i]); });
}

/// The only time at which a part is seen; -1 = it always is.
int only_time_of(const GlbTiles& tiles, const Part& part) {
  if (tiles.only_in.empty()) return -1;
  const auto time = [&](std::size_t triangle) { return tiles.only_in[tiles.triangle_tile[triangle]]; };
  const int first = time(part.triangles.front());
  const bool is_same = std::all_of(part.triangles.begin(), part.triangles.end(),
                                   [&](std::size_t triangle) { return time(triangle) == first; });
  return is_same ? first : -1;
}

/// @param origin  Of the points.
std::string mesh_text(const Mesh& mesh, const GlbTiles& tiles, const Part& part, const std::string& name,
                      const std::vector<std::string>& materials, const Vec3& origin, const std::vector<double>& times) {
  const Compact points = compact(mesh.triangles, part, mesh.positions.size());
  const Compact uvs = compact(mesh.uv_triangles, part, mesh.uvs.size());
  const auto position = [&](std::size_t i) -> Vec3 { return mesh.positions[points.entries[i]] - origin; };
  Box box;
  for (std::size_t i = 0; i < points.entries.size(); ++i) {
    box.low = box.low.cwiseMin(position(i));
    box.high = box.high.cwiseMax(position(i));
  }
  std::string out =
      "    def Mesh \"" + name + "\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {\n";
  const auto line = [&](const std::string& text) { out += "        " + text + "\n"; };
  line("uniform bool doubleSided = 1");
  if (!points.entries.empty()) line("float3[] extent = [" + tuple(box.low) + ", " + tuple(box.high) + "]");
  line("int[] faceVertexCounts = " + list(part.triangles.size(), [](std::size_t) { return std::string("3"); }));
  line("int[] faceVertexIndices = " + indices(points.corners));
  line("point3f[] points = " + list(points.entries.size(), [&](std::size_t i) { return tuple(position(i)); }));
  if (!mesh.normal_triangles.empty()) {
    line("normal3f[] normals = " +
         list(3 * part.triangles.size(),
              [&](std::size_t i) {
                const Triangle& triangle = mesh.normal_triangles[part.triangles[i / 3]];
                return tuple(mesh.normals[triangle[i % 3]]);
              }) +
         " (\n            interpolation = \"faceVarying\"\n        )");
  }
  line("texCoord2f[] primvars:st = " +
       list(uvs.entries.size(), [&](std::size_t i) { return tuple(mesh.uvs[uvs.entries[i]]); }) +
       " (\n            interpolation = \"faceVarying\"\n        )");
  line("int[] primvars:st:indices = " + indices(uvs.corners));
  line("uniform token subdivisionScheme = \"none\"");
  if (const int only = only_time_of(tiles, part); only >= 0 && times.size() > 1) {
    line("token visibility.timeSamples = " + samples_text(times, [&](std::size_t i) {
           return static_cast<int>(i) == only ? std::string("\"inherited\"") : std::string("\"invisible\"");
         }));
  }
  if (materials.size() == 1) line("rel material:binding = " + materials.front());
  const std::vector<std::string> subsets = subset_names(tiles);
  for (std::size_t tile = 0; materials.size() > 1 && tile < materials.size(); ++tile) {
    std::vector<int> faces;
    for (std::size_t i = 0; i < part.triangles.size(); ++i) {
      if (tiles.triangle_tile[part.triangles[i]] == static_cast<int>(tile)) faces.push_back(static_cast<int>(i));
    }
    if (faces.empty()) continue;
    out += "\n        def GeomSubset \"" + subsets[tile] +
           "\" (\n            prepend apiSchemas = [\"MaterialBindingAPI\"]\n        )\n        {\n"
           "            uniform token elementType = \"face\"\n            uniform token familyName = \"materialBind\"\n"
           "            int[] indices = " +
           indices(faces) + "\n            rel material:binding = " + materials[tile] + "\n        }\n";
  }
  return out + "    }\n";
}

/// A texture that changes with time. @param more  Further inputs, each a line.
std::string texture_text(const std::string& name, const TextureFiles::Series& files, std::size_t tile,
                         const std::vector<double>& times, const std::string& material, const std::string& color_space,
                         const std::string& more, const std::string& output) {
  std::string out = "            def Shader \"" + name + "\"\n            {\n";
  const auto line = [&](const std::string& text) { out += "                " + text + "\n"; };
  line("uniform token info:id = \"UsdUVTexture\"");
  line("asset inputs:file = " + asset(files.front()[tile]));
  if (times.size() > 1) {
    line("asset inputs:file.timeSamples = " +
         samples_text(times, [&](std::size_t i) { return asset(files[i][tile]); }));
  }
  line("token inputs:sourceColorSpace = \"" + color_space + "\"");
  line("float2 inputs:st.connect = <" + material + "/st.outputs:result>");
  line("token inputs:wrapS = \"clamp\"");
  line("token inputs:wrapT = \"clamp\"");
  out += more;
  line(output);
  return out + "            }\n";
}

std::string material_text(const std::string& name, const std::string& path, const TextureFiles& files, std::size_t tile,
                          const std::vector<double>& times, const UsdOptions& options) {
  const std::string indent(16, ' ');
  std::string out = "        def Material \"" + name + "\"\n        {\n            token outputs:surface.connect = <" +
                    path + "/surface.outputs:surface>\n\n            def Shader \"surface\"\n            {\n" + indent +
                    "uniform token info:id = \"UsdPreviewSurface\"\n" + indent +
                    "color3f inputs:diffuseColor.connect = <" + path + "/color.outputs:rgb>\n" + indent +
                    (files.metalness.empty() ? "float inputs:metallic = 0"
                                             : "float inputs:metallic.connect = <" + path + "/metalness.outputs:r>") +
                    "\n";
  // Does not change with time in a preview surface: the largest.
  const double f0 = *std::max_element(files.reflectances.begin(), files.reflectances.end());
  if (f0 != 0.04) {
    out += indent + "float inputs:ior = " + number_text(rounded(index_of_refraction(f0), 9)) + "\n";
  }
  if (!files.normals.empty()) out += indent + "normal3f inputs:normal.connect = <" + path + "/normal.outputs:rgb>\n";
  out += indent +
         (files.roughness.empty() ? "float inputs:roughness = " + number_text(options.roughness)
                                  : "float inputs:roughness.connect = <" + path + "/roughness.outputs:r>") +
         "\n";
  out += indent + "token outputs:surface\n            }\n            def Shader \"st\"\n            {\n" + indent +
         "uniform token info:id = \"UsdPrimvarReader_float2\"\n" + indent + "string inputs:varname = \"st\"\n" +
         indent + "float2 outputs:result\n            }\n";
  out += texture_text("color", files.base_colors, tile, times, path, "sRGB", "", "float3 outputs:rgb");
  if (!files.normals.empty()) {
    out += texture_text(
        "normal", files.normals, tile, times, path, "raw",
        indent + "float4 inputs:scale = (2, 2, 2, 1)\n" + indent + "float4 inputs:bias = (-1, -1, -1, 0)\n",
        "float3 outputs:rgb");
  }
  if (!files.roughness.empty())
    out += texture_text("roughness", files.roughness, tile, times, path, "raw", "", "float outputs:r");
  if (!files.metalness.empty())
    out += texture_text("metalness", files.metalness, tile, times, path, "raw", "", "float outputs:r");
  return out + "        }\n";
}

}  // namespace

std::string usd_text(const Mesh& mesh, const GlbTiles& tiles, const TextureFiles& files,
                     const std::vector<double>& times, const UsdOptions& options) {
  const std::string root = root_name(options);
  const double span = times.back() - times.front();
  std::string credits;
  for (const std::string& credit : options.credits) credits += (credits.empty() ? "" : "; ") + credit;
  const std::string says_credits = credits.empty() ? credits : "\n        string credits = " + quoted_text(credits);
  std::string out = "#usda 1.0\n(\n    customLayerData = {\n        string patinate_key = " + quoted_text(options.key) +
                    "\n        string time_unit = " + quoted_text(options.time_unit) + says_credits +
                    "\n    }\n    defaultPrim = \"" + root + "\"\n    endTimeCode = " + number_text(times.back()) +
                    "\n    metersPerUnit = " + number_text(options.meters_per_unit) +
                    "\n    startTimeCode = " + number_text(times.front()) +
                    "\n    timeCodesPerSecond = " + number_text(span > 0.0 ? span / options.duration_s : 24.0) +
                    "\n    upAxis = \"Y\"\n)\n\ndef Xform \"" + root + "\" (\n    kind = \"component\"\n)\n{\n";
  const Vec3 origin = model_origin(mesh);
  if (!origin.isZero(0.0))
    out += "    double3 xformOp:translate = (" + number_text(origin.x()) + ", " + number_text(origin.y()) + ", " +
           number_text(origin.z()) + ")\n    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\n";
  std::set<std::string> material_names;
  std::vector<std::string> names, bindings;
  for (const std::string& tile : tiles.names) {
    names.push_back(prim_name(tile_material(tile), material_names));
    bindings.push_back("</" + root + "/Materials/" + names.back() + ">");
  }
  for (const auto& [part, name] : named_parts(mesh, options))
    out += mesh_text(mesh, tiles, part, name, bindings, origin, times) + "\n";
  out += "    def Scope \"Materials\"\n    {\n";
  for (std::size_t tile = 0; tile < names.size(); ++tile) {
    out += material_text(names[tile], "/" + root + "/Materials/" + names[tile], files, tile, times, options);
  }
  return out + "    }\n}\n";
}

std::vector<std::string> usd_geometries(const Mesh& mesh, const GlbTiles& tiles, const UsdOptions& options) {
  const std::vector<std::string> subsets = subset_names(tiles);
  std::vector<std::string> geometries;
  for (std::size_t tile = 0; tile < subsets.size(); ++tile) {
    std::string list;
    for (const auto& [part, name] : named_parts(mesh, options)) {
      list += (list.empty() ? "/" : ", /") + root_name(options) + "/" + name +
              (subsets.size() > 1 ? "/" + subsets[tile] : "");
    }
    geometries.push_back(std::move(list));
  }
  return geometries;
}

}  // namespace patinate
