#include "libcommon/mesh_files/gltf_accessor.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Component of this type at `bytes`.
double component_at(const unsigned char* bytes, int type, bool is_normalized) {
  const auto as = [&](auto x) {
    std::memcpy(&x, bytes, sizeof x);
    if (!is_normalized) return static_cast<double>(x);
    return std::max(static_cast<double>(x) / static_cast<double>(std::numeric_limits<decltype(x)>::max()), -1.0);
  };
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return as(std::int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return as(std::uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return as(std::int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return as(std::uint16_t{});
    case TINYGLTF_COMPONENT_TYPE_INT:
      return as(std::int32_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return as(std::uint32_t{});
    default:
      break;
  }
  float x = 0.0F;
  std::memcpy(&x, bytes, sizeof x);
  return static_cast<double>(x);
}

int component_size(int type) {
  if (type == TINYGLTF_COMPONENT_TYPE_DOUBLE) return 0;  // glTF has none.
  return std::max(0, tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
}

bool is_unsigned(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

/// Number of bytes of all buffers.
std::size_t num_bytes(const tinygltf::Model& model) {
  std::size_t sum = 0;
  for (const tinygltf::Buffer& buffer : model.buffers) sum += buffer.data.size();
  return sum;
}

}  // namespace

GltfAccessor::GltfAccessor(const std::string& file, const tinygltf::Model& model, int index, const std::string& what)
    : model_(model), file_(file), what_(what + " (accessor " + std::to_string(index) + ")") {
  if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size()) fail("does not exist");
  const tinygltf::Accessor& a = model.accessors[index];
  const int size = component_size(a.componentType);
  num_components_ = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
  if (size == 0 || num_components_ <= 0) fail("has an unknown component type");
  const auto element_size = static_cast<std::size_t>(size * num_components_);
  count_ = a.count;
  component_ = a.componentType;
  is_normalized_ = a.normalized;
  if (a.bufferView >= 0) {
    base_ = elements(a.bufferView, a.byteOffset, count_, element_size);
  } else if (!a.sparse.isSparse) {
    fail("has no buffer view");
  } else if (count_ > num_bytes(model)) {
    fail("has " + std::to_string(count_) + " elements, more than the file has bytes");
  }
  if (a.sparse.isSparse) read_sparse(a, element_size);
}

void GltfAccessor::fail(const std::string& problem) const { throw IoError(file_, what_ + ": " + problem); }

GltfAccessor::Elements GltfAccessor::elements(int view_index, std::size_t offset, std::size_t count,
                                              std::size_t element_size) const {
  if (view_index < 0 || static_cast<std::size_t>(view_index) >= model_.bufferViews.size()) fail("has no buffer view");
  const tinygltf::BufferView& view = model_.bufferViews[view_index];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model_.buffers.size()) fail("has no buffer");
  const std::vector<unsigned char>& bytes = model_.buffers[view.buffer].data;
  const std::size_t stride = view.byteStride == 0 ? element_size : view.byteStride;
  if (stride < element_size || stride > 65536) fail("has a wrong byteStride");
  if (view.byteLength > bytes.size() || view.byteOffset > bytes.size() - view.byteLength) {
    fail("its buffer view ends behind its buffer of " + std::to_string(bytes.size()) + " bytes");
  }
  if (count > view.byteLength || offset > view.byteLength ||
      (count > 0 && (count - 1) * stride + element_size > view.byteLength - offset)) {
    fail(std::to_string(count) + " elements do not fit into its buffer view of " + std::to_string(view.byteLength) +
         " bytes");
  }
  return {bytes.data() + view.byteOffset + offset, stride};
}

void GltfAccessor::read_sparse(const tinygltf::Accessor& accessor, std::size_t element_size) {
  const auto& sparse = accessor.sparse;
  const int index_type = sparse.indices.componentType;
  if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 || !is_unsigned(index_type))
    fail("its sparse part is no valid one");
  const auto count = static_cast<std::size_t>(sparse.count);
  const Elements indices = elements(sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                                    count, static_cast<std::size_t>(component_size(index_type)));
  sparse_ = elements(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset), count, element_size);
  for (std::size_t i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(component_at(indices.first + i * indices.stride, index_type, false));
    if (index >= count_ || (i > 0 && index <= sparse_indices_.back()))
      fail("its sparse indices do not increase, or exceed its " + std::to_string(count_) + " elements");
    sparse_indices_.push_back(index);
  }
}

bool GltfAccessor::is_index() const { return num_components_ == 1 && is_unsigned(component_); }

double GltfAccessor::value(std::size_t i, int c) const {
  Elements from = base_;
  std::size_t row = i;
  const auto found = std::lower_bound(sparse_indices_.begin(), sparse_indices_.end(), i);
  if (found != sparse_indices_.end() && *found == i) {
    from = sparse_;
    row = static_cast<std::size_t>(found - sparse_indices_.begin());
  }
  if (from.first == nullptr) return 0.0;
  const auto size = static_cast<std::size_t>(component_size(component_));
  return component_at(from.first + row * from.stride + static_cast<std::size_t>(c) * size, component_, is_normalized_);
}

}  // namespace patinate
