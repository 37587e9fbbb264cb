#include "libcommon/output/materialx.h"

#include <cctype>
#include <set>

#include "libcommon/core/text.h"

namespace patinate {

namespace {

/// Escapes an attribute's value.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out;
}

/// A name of MaterialX, unlike those before: letters, digits and `_`.
std::string element_name(const std::string& name, std::set<std::string>& taken) {
  std::string out;
  for (const char c : name)
    out += std::isalnum(static_cast<unsigned char>(c)) != 0 && static_cast<unsigned char>(c) < 0x80 ? c : '_';
  std::string unlike = out;
  for (int i = 2; !taken.insert(unlike).second; ++i) unlike = out + "_" + std::to_string(i);
  return unlike;
}

std::string input(const std::string& name, const std::string& type, const std::string& how) {
  return "<input name=\"" + name + "\" type=\"" + type + "\" " + how + " />\n";
}

std::string image(const std::string& name, const std::string& type, const std::string& file,
                  const std::string& color_space) {
  return "    <image name=\"" + name + "\" type=\"" + type + "\">\n      " +
         input("file", "filename",
               "value=\"" + escaped(file) + "\"" + (color_space.empty() ? "" : " colorspace=\"" + color_space + "\"")) +
         "      " + input("uaddressmode", "string", "value=\"clamp\"") + "      " +
         input("vaddressmode", "string", "value=\"clamp\"") + "    </image>\n";
}

/// One material: its graph of images, its shaders, itself.
class MaterialText {
 public:
  MaterialText(std::string name, std::string label, double roughness)
      : name_(std::move(name)), label_(std::move(label)), roughness_(roughness) {}

  void add(const TextureFiles& files, std::size_t time, std::size_t tile) {
    shade("base_color", "color3", "color", files.base_colors[time][tile], "srgb_texture");
    if (files.roughness.empty())
      shader_ += "    " + input("specular_roughness", "float", "value=\"" + number_text(roughness_) + "\"");
    else
      shade("specular_roughness", "float", "roughness", files.roughness[time][tile], "");
    if (!files.metalness.empty()) shade("metalness", "float", "metalness", files.metalness[time][tile], "");
    const bool has_colors = !files.reflectance[time].empty();
    if (const double f0 = files.reflectances[time]; f0 != 0.04 || has_colors)
      shader_ +=
          "    " + input("specular_IOR", "float", "value=\"" + number_text(rounded(index_of_refraction(f0), 9)) + "\"");
    if (has_colors) shade("specular_color", "color3", "reflectance", files.reflectance[time][tile], "srgb_texture");
    if (!files.normals.empty()) {
      graph_ += image("normal_image", "vector3", files.normals[time][tile], "") +
                "    <normalmap name=\"normal\" type=\"vector3\">\n      " +
                input("in", "vector3", "nodename=\"normal_image\"") + "    </normalmap>\n";
      connect("normal", "vector3", "normal");
    }
    if (!files.heights.empty()) {
      graph_ += image("height", "float", files.heights[time][tile], "");
      outputs_ += output("height", "float");
      displacement_ = true;
    }
  }

  [[nodiscard]] std::string text() const {
    const std::string graph = name_ + "_maps";
    std::string out = "  <nodegraph name=\"" + graph + "\">\n" + graph_ + outputs_ + "  </nodegraph>\n";
    out += "  <standard_surface name=\"" + name_ + "_surface\" type=\"surfaceshader\">\n" + shader_ +
           "  </standard_surface>\n";
    if (displacement_) {
      out += "  <displacement name=\"" + name_ + "_displacement\" type=\"displacementshader\">\n    " +
             input("displacement", "float", "nodegraph=\"" + graph + "\" output=\"out_height\"") + "    " +
             input("scale", "float", "value=\"1\"") + "  </displacement>\n";
    }
    out += "  <surfacematerial name=\"" + name_ + "\" type=\"material\" uiname=\"" + escaped(label_) + "\">\n    " +
           input("surfaceshader", "surfaceshader", "nodename=\"" + name_ + "_surface\"");
    if (displacement_)
      out += "    " + input("displacementshader", "displacementshader", "nodename=\"" + name_ + "_displacement\"");
    return out + "  </surfacematerial>\n";
  }

 private:
  static std::string output(const std::string& node, const std::string& type) {
    return "    <output name=\"out_" + node + "\" type=\"" + type + "\" nodename=\"" + node + "\" />\n";
  }
  void connect(const std::string& to, const std::string& type, const std::string& node) {
    outputs_ += output(node, type);
    shader_ += "    " + input(to, type, "nodegraph=\"" + name_ + "_maps\" output=\"out_" + node + "\"");
  }
  void shade(const std::string& to, const std::string& type, const std::string& node, const std::string& file,
             const std::string& color_space) {
    graph_ += image(node, type, file, color_space);
    connect(to, type, node);
  }

  std::string name_, label_;
  double roughness_;
  std::string graph_, outputs_, shader_;
  bool displacement_ = false;
};

}  // namespace

std::string materialx_text(const std::vector<std::string>& tile_names, const TextureFiles& files,
                           const MaterialXOptions& options) {
  std::set<std::string> taken;
  std::string doc = "patinate_key=" + options.key;
  for (const std::string& credit : options.credits) doc += "; " + credit;
  std::string out =
      "<?xml version=\"1.0\"?>\n<materialx version=\"1.38\" colorspace=\"lin_rec709\" doc=\"" + escaped(doc) + "\">\n";
  std::string looks;
  for (std::size_t time = 0; time < files.base_colors.size(); ++time) {
    const std::string& label = options.time_names[time];
    looks += "  <look name=\"" + element_name("look_" + label, taken) + "\" uiname=\"" + escaped(label) + "\">\n";
    for (std::size_t tile = 0; tile < tile_names.size(); ++tile) {
      const std::string name = element_name(tile_material(tile_names[tile]) + "_" + label, taken);
      MaterialText material(name, label, options.roughness);
      material.add(files, time, tile);
      out += material.text();
      looks += "    <materialassign name=\"assign_" + name + "\" material=\"" + name + "\" geom=\"" +
               escaped(options.geometries[options.geometries.size() > 1 ? tile : 0]) + "\" />\n";
    }
    looks += "  </look>\n";
  }
  return out + looks + "</materialx>\n";
}

}  // namespace patinate
