/// \file
/// The numbers of a glTF accessor, with every bound checked. For the readers of glTF.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

namespace tinygltf {
struct Accessor;
class Model;
}  // namespace tinygltf

namespace patinate {

/// Elements of one accessor: of its buffer view (zeros without one), and what its sparse part puts in their place.
/// Integers that are normalized become [0, 1] or [-1, 1]. Looks into the model's buffers, which must outlive it.
class GltfAccessor {
 public:
  /// @param what  Of the file's part that uses it, for errors. @throws IoError
  GltfAccessor(const std::string& file, const tinygltf::Model& model, int index, const std::string& what);

  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] int num_components() const { return num_components_; }
  /// Whether the elements are single unsigned integers.
  [[nodiscard]] bool is_index() const;
  /// Component `c` of element `i`.
  [[nodiscard]] double value(std::size_t i, int c) const;
  template <int N>
  [[nodiscard]] Eigen::Matrix<double, N, 1> vector(std::size_t i) const {
    Eigen::Matrix<double, N, 1> v;
    for (int c = 0; c < N; ++c) v[c] = value(i, c);
    return v;
  }

 private:
  /// Elements in a buffer.
  struct Elements {
    const unsigned char* first = nullptr;  ///< Null: all are zero.
    std::size_t stride = 0;                ///< Bytes from one to the next.
  };

  [[noreturn]] void fail(const std::string& problem) const;
  [[nodiscard]] Elements elements(int view, std::size_t offset, std::size_t count, std::size_t element_size) const;
  void read_sparse(const tinygltf::Accessor& accessor, std::size_t element_size);

  const tinygltf::Model& model_;
  std::string file_, what_;
  std::size_t count_ = 0;
  int num_components_ = 0;
  int component_ = 0;
  bool is_normalized_ = false;
  Elements base_, sparse_;
  std::vector<std::size_t> sparse_indices_;  ///< Increasing: of the elements that the sparse part holds.
};

}  // namespace patinate
