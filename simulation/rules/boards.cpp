#include "simulation/rules/boards.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace patinate::simulation {

namespace {

/// For every position the first that is equal to it.
std::vector<int> welded(const std::vector<Vec3>& positions) {
  std::vector<int> order(positions.size());
  std::iota(order.begin(), order.end(), 0);
  const auto at = [&](int i) -> const Vec3& { return positions[i]; };
  const auto key = [&](int i) { return std::array<double, 3>{at(i).x(), at(i).y(), at(i).z()}; };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  std::vector<int> first(positions.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto i = static_cast<std::size_t>(order[k]);
    const bool is_equal = k > 0 && at(order[k]) == at(order[k - 1]);
    first[i] = is_equal ? first[order[k - 1]] : order[k];
  }
  return first;
}

/// Sets of numbers that are joined one by one; a set's name is the least of them.
class JoinedSets {
 public:
  explicit JoinedSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int i) {
    // Each link that is passed goes one farther on from then on [Tarjan and van Leeuwen 1984, path halving].
    while (i != parent_[i]) {
      int& parent = parent_[i];
      parent = parent_[parent];
      i = parent;
    }
    return i;
  }
  void join(int a, int b) {
    const int x = of(a), y = of(b);
    parent_[std::max(x, y)] = std::min(x, y);
  }

 private:
  std::vector<int> parent_;
};

Board board_of(const Box& box, std::int64_t number) {
  Board board{.middle_mm = box.center(), .number = number};
  const Vec3 sides = box.high - box.low;
  int longest = 0;
  for (int k = 1; k < 3; ++k) longest = sides[k] > sides[longest] ? k : longest;
  board.along = Vec3::Unit(longest);
  double widest = 0.0;
  for (int k = 0; k < 3; ++k) widest = std::max(widest, k == longest ? 0.0 : sides[k]);
  board.half_width_mm = 0.5 * widest;
  return board;
}

}  // namespace

Boards find_boards(const SceneMesh& scene_mesh, const std::vector<std::int64_t>& first_numbers) {
  const Mesh& mesh = scene_mesh.mesh;
  const std::vector<int> first = welded(mesh.positions);
  JoinedSets pieces(mesh.positions.size());
  const auto at = [&](int i) { return first[i]; };
  for (const Triangle& t : mesh.triangles) {
    pieces.join(at(t[0]), at(t[1]));
    pieces.join(at(t[0]), at(t[2]));
  }
  Boards found;
  std::vector<int> index(mesh.positions.size(), -1);
  std::vector<std::int64_t> next = first_numbers;
  std::vector<Box> boxes;
  std::vector<std::int64_t> numbers;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    int& board = index[pieces.of(at(mesh.triangles[t][0]))];
    if (board < 0) {
      board = static_cast<int>(boxes.size());
      boxes.emplace_back();
      numbers.push_back(next[scene_mesh.object[t]]++);
    }
    found.of_triangle.push_back(board);
    Box& box = boxes[board];
    for (const int corner : mesh.triangles[t]) {
      box.low = box.low.cwiseMin(mesh.positions[corner]);
      box.high = box.high.cwiseMax(mesh.positions[corner]);
    }
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) found.boards.push_back(board_of(boxes[i], numbers[i]));
  return found;
}

}  // namespace patinate::simulation
