// The module `patinate-draco`: see draco_module.h.
#include "libcommon/mesh_files/draco_module.h"

#include <draco/compression/decode.h>

#include <array>
#include <cstring>
#include <memory>
#include <utility>

namespace patinate {

namespace {

/// Values of all points, one after the other; empty where they are no such numbers.
template <class Number>
std::vector<unsigned char> values_of(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                                     int num_components) {
  const auto n = static_cast<std::size_t>(num_components);
  std::vector<unsigned char> bytes(mesh.num_points() * n * sizeof(Number));
  std::vector<Number> value(n);
  for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
    if (!attribute.ConvertValue<Number>(attribute.mapped_index(i), static_cast<std::int8_t>(num_components),
                                        value.data()))
      return {};
    std::memcpy(&bytes[i.value() * n * sizeof(Number)], value.data(), n * sizeof(Number));
  }
  return bytes;
}

class Decoded final : public DracoMesh {
 public:
  explicit Decoded(std::unique_ptr<draco::Mesh> mesh) : mesh_(std::move(mesh)) {}

  [[nodiscard]] std::uint32_t num_points() const override { return mesh_->num_points(); }
  [[nodiscard]] std::vector<std::uint32_t> indices() const override {
    std::vector<std::uint32_t> indices;
    for (draco::FaceIndex f(0); f < mesh_->num_faces(); ++f) {
      for (const draco::PointIndex& corner : mesh_->face(f)) indices.push_back(corner.value());
    }
    return indices;
  }
  [[nodiscard]] bool has_attribute(std::uint32_t id) const override {
    return mesh_->GetAttributeByUniqueId(id) != nullptr;
  }
  [[nodiscard]] std::vector<unsigned char> values(std::uint32_t id, int component_type,
                                                  int num_components) const override {
    using ValuesOf = std::vector<unsigned char> (*)(const draco::Mesh&, const draco::PointAttribute&, int);
    constexpr int kFirst = 5120, kMaxComponents = 16;  // glTF's BYTE; signed 32 bits and double it has not.
    constexpr std::array<ValuesOf, 7> kByType{
        values_of<std::int8_t>,   values_of<std::uint8_t>, values_of<std::int16_t>, values_of<std::uint16_t>, nullptr,
        values_of<std::uint32_t>, values_of<float>};
    const int type = component_type - kFirst;
    if (type < 0 || type >= static_cast<int>(kByType.size()) || kByType[type] == nullptr) return {};
    if (num_components < 1 || num_components > kMaxComponents) return {};
    return kByType[type](*mesh_, *mesh_->GetAttributeByUniqueId(id), num_components);
  }

 private:
  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace

}  // namespace patinate

extern "C" [[gnu::visibility("default")]] patinate::DracoMesh* patinate_draco_1(const unsigned char* bytes,
                                                                                std::size_t size) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes), size);
  auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!mesh.ok()) return nullptr;
  return std::make_unique<patinate::Decoded>(std::move(mesh).value()).release();
}
