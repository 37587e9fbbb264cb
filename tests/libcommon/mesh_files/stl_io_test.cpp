#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/libcommon/mesh_files/mesh_bytes.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::mesh_of;

std::string stl_facet(const std::string& a, const std::string& b, const std::string& c) {
  return "facet normal nan nan nan\n outer loop\n  vertex " + a + "\n  vertex " + b + "\n  vertex " + c +
         "\n endloop\nendfacet\n";
}

const std::string kAsciiStl = "solid a square\n" + stl_facet("0 0 0", "1 0 0", "1 1 0.5") +
                              stl_facet("0 0 0", "+1 1.0e0 0.5", "0 1 0") + "endsolid a square\n";

std::string binary_stl(const std::string& header, const std::vector<std::array<float, 9>>& facets) {
  std::string bytes = header + std::string(80 - header.size(), ' ');
  const auto append = [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); };
  const auto count = static_cast<std::uint32_t>(facets.size());
  append(&count, sizeof count);
  for (const std::array<float, 9>& corners : facets) {
    constexpr std::array<float, 3> kNormal{};
    append(kNormal.data(), sizeof kNormal);
    append(corners.data(), sizeof corners);
    bytes += std::string(2, '\0');
  }
  return bytes;
}

TEST(ReadStl, ReadsBothFormsAlike) {
  // A binary file whose header begins with `solid` is told from text by its size.
  const std::string binary = binary_stl("solid", {{0, 0, 0, 1, 0, 0, 1, 1, 0.5}, {0, 0, 0, 1, 1, 0.5, 0, 1, 0}});
  for (const std::string& content : {kAsciiStl, binary}) {
    const Mesh mesh = mesh_of("a.stl", content);
    ASSERT_EQ(mesh.num_triangles(), 2);
    ASSERT_EQ(mesh.positions.size(), 4u);  // Corners that facets share are one.
    EXPECT_EQ(mesh.positions[2], Vec3(1, 1, 0.5));
    EXPECT_FALSE(mesh.has_uvs());
  }
}

TEST(ReadStl, SolidsOfAFileAreNodes) {
  const Mesh mesh = mesh_of("a.stl", kAsciiStl + "solid\n" + stl_facet("0 0 1", "1 0 1", "1 1 1") + "endsolid\n");
  ASSERT_EQ(mesh.surfaces.size(), 2u);
  EXPECT_EQ(mesh.surfaces[0].node, "a square");
  EXPECT_EQ(mesh.surfaces[1].node, "");
}

TEST(ReadStl, SaysThatAFileIsTruncatedAtEveryLength) {
  const std::string binary = binary_stl("", {{0, 0, 0, 1, 0, 0, 1, 1, 0.5}});
  for (const std::string& whole : {kAsciiStl.substr(0, kAsciiStl.rfind(" a square")), binary}) {
    for (std::size_t length = 1; length < whole.size(); ++length)
      EXPECT_NE(error_of("a.stl", whole.substr(0, length)), "") << length;
  }
}

TEST(ReadStl, NamesWhatIsWrong) {
  EXPECT_EQ(error_of("a.stl", "solid x\nendsolid x\n"), "no facets");
  EXPECT_EQ(error_of("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 zero 0\n"),
            "line 4: found `zero`; expected a number");
  EXPECT_EQ(error_of("a.stl", "solid x\n" + stl_facet("0 0 0", "1 0 0", "1 1 0")),
            "line 9: the file ends before `endsolid`: it is cut off");
  EXPECT_EQ(error_of("a.stl", binary_stl("", {{0, 0, 0, 1, 0, 0, 1, 1, 0.5}}) + "more"),
            "is no STL file, or cut off: it says that it holds 1 facets, which take 134 bytes, and has 138");
}

}  // namespace
}  // namespace patinate
