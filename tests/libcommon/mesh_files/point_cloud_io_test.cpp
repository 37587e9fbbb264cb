#include "patinate/mesh_files/point_cloud_io.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string>

#include "libcommon/core/files.h"
#include "libcommon/geometry/nearest_points.h"
#include "libcommon/mesh_files/point_cloud_formats.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

std::filesystem::path write_file(const TempFolder& folder, const std::string& name, const std::string& bytes) {
  std::ofstream(folder / name, std::ios::binary) << bytes;
  return folder / name;
}

std::string cloud_error(const std::filesystem::path& path) {
  try {
    (void)read_point_cloud(path);
  } catch (const IoError& e) {
    return e.what();
  }
  return "";
}

constexpr const char* kGrid =
    "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\nelement vertex 5\nproperty float x\nproperty "
    "float y\nproperty float z\n"
    "element range_grid 6\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0.125\n1 0 0\nnan 0 0\n0 1 0\n2 1 0.1\n1 0\n1 1\n1 2\n1 3\n0\n1 4\n";

TEST(PointCloudIo, ARangeGridKeepsItsCellsAndLosesWhatWasNotMeasured) {
  const TempFolder folder;
  const PointCloud cloud = read_point_cloud(write_file(folder, "grid.ply", kGrid));
  ASSERT_EQ(cloud.num_points(), 4);
  ASSERT_TRUE(cloud.grid);
  EXPECT_EQ(cloud.grid->width, 3);
  EXPECT_EQ(cloud.grid->cell, (std::vector<int>{0, 1, -1, 2, -1, 3}));
  EXPECT_EQ(cloud.points[3], Vec3(2, 1, 0.1)) << "text is read as double, not through float";
  EXPECT_EQ(cloud.toward_scanner, Vec3(0, 0, 1));
}

TEST(PointCloudIo, AGridThatIsNotTheSizeItSaysIsRefused) {
  const TempFolder folder;
  std::string text = kGrid;
  text.replace(text.find("num_cols 3"), 10, "num_cols 4");
  EXPECT_NE(cloud_error(write_file(folder, "grid.ply", text)).find("6 cells; num_cols and num_rows say 4 x 2"),
            std::string::npos);
}

TEST(PointCloudIo, WhatIsWrittenIsReadBackToTheLastBit) {
  const TempFolder folder;
  PointCloud cloud;
  for (int i = 0; i < 5; ++i) {
    cloud.points.emplace_back(1e6 + i / 3.0, std::sin(i), -1e-9 * i);
    cloud.normals.push_back(Vec3(std::cos(i), std::sin(i), 0.0).normalized());
    cloud.colors.emplace_back(i / 255.0, 1.0, 0.0);
  }
  cloud.triangles = {{0, 1, 2}, {2, 3, 4}};
  write_point_cloud(folder / "a.ply", cloud);
  const PointCloud back = read_point_cloud(folder / "a.ply");
  EXPECT_EQ(back.points, cloud.points);
  EXPECT_EQ(back.triangles, cloud.triangles);
  EXPECT_EQ(back.colors, cloud.colors);
  ASSERT_EQ(back.normals.size(), cloud.normals.size());
  for (std::size_t i = 0; i < back.normals.size(); ++i)
    EXPECT_NEAR((back.normals[i] - cloud.normals[i]).norm(), 0.0, 1e-15);
}

TEST(PointCloudIo, AnObjGivesItsVerticesWithFacesOrWithout) {
  const TempFolder folder;
  const PointCloud points = read_point_cloud(write_file(folder, "p.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0 0\n"));
  EXPECT_EQ(points.num_points(), 3) << "nothing is merged";
  EXPECT_EQ(points.points[1].x(), 0.1);
  const PointCloud mesh =
      read_point_cloud(write_file(folder, "m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"));
  EXPECT_EQ(mesh.triangles.size(), 2u);
}

std::string pcd_header(const std::string& form, int width, int height) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z rgb\nSIZE 4 "
         "4 4 4 4 4 4\nTYPE F F F F F F U\n"
         "COUNT 1 1 1 1 1 1 1\nWIDTH " +
         std::to_string(width) + "\nHEIGHT " + std::to_string(height) + "\nVIEWPOINT 0 0 -2 1 0 0 0\nPOINTS " +
         std::to_string(width * height) + "\nDATA " + form + "\n";
}

TEST(PointCloudIo, ThePcdFormsSayTheSame) {
  const TempFolder folder;
  const float nan = std::nanf("");
  const std::vector<std::array<float, 3>> points{{0.5f, 0, 1}, {nan, nan, nan}, {0, 0.25f, 1}, {1, 1, 2}};
  std::string ascii = pcd_header("ascii", 2, 2), binary = pcd_header("binary", 2, 2),
              compressed = pcd_header("binary_compressed", 2, 2), by_field;
  const auto append = [](std::string& bytes, auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const auto& p : points) {
    for (const float v : p) ascii += (std::isnan(v) ? "nan" : std::to_string(v)) + " ";
    ascii += "0 0 -1 " + std::to_string(0x10ff00) + "\n";
    for (const float v : p) append(binary, v);
    for (const float v : {0.0f, 0.0f, -1.0f}) append(binary, v);
    append(binary, std::uint32_t{0x10ff00});
  }
  for (std::size_t k = 0; k < 6; ++k) {
    for (const auto& p : points) append(by_field, k < 3 ? p[k] : k == 5 ? -1.0f : 0.0f);
  }
  for (std::size_t i = 0; i < 4; ++i) append(by_field, std::uint32_t{0x10ff00});
  std::string lzf;  // Literals only.
  for (std::size_t i = 0; i < by_field.size(); i += 32) {
    const std::string part = by_field.substr(i, 32);
    lzf += static_cast<char>(part.size() - 1);
    lzf += part;
  }
  append(compressed, static_cast<std::uint32_t>(lzf.size()));
  append(compressed, static_cast<std::uint32_t>(by_field.size()));
  compressed += lzf;
  for (const auto& [name, text] : {std::pair{"a.pcd", ascii}, {"b.pcd", binary}, {"c.pcd", compressed}}) {
    const PointCloud cloud = read_point_cloud(write_file(folder, name, text));
    ASSERT_EQ(cloud.num_points(), 3) << name;
    EXPECT_EQ(cloud.points[1], Vec3(0, 0.25, 1)) << name;
    EXPECT_EQ(cloud.normals[2], Vec3(0, 0, -1)) << name;
    EXPECT_NEAR(cloud.colors[0].y(), 1.0, 1e-15) << name;
    ASSERT_TRUE(cloud.grid) << name;
    EXPECT_EQ(cloud.grid->cell, (std::vector<int>{0, -1, 1, 2})) << name;
    EXPECT_EQ(cloud.scanner, Vec3(0, 0, -2)) << name;
  }
}

TEST(PointCloudIo, LzfUndoesBackReferencesThatOverlap) {
  // "a", then 9 bytes from 1 back; by the format's definition.
  EXPECT_EQ(lzf_decompress(std::string("\0a\xe0\0\0", 5), 10), "aaaaaaaaaa");
  EXPECT_THROW((void)lzf_decompress(std::string("\0a\xe0\0\5", 5), 10), InvalidInput) << "before the beginning";
  EXPECT_THROW((void)lzf_decompress(std::string("\0a\xe0\0\0", 5), 9), InvalidInput);
  EXPECT_THROW((void)lzf_decompress("a", 1u << 30), InvalidInput) << "refused before anything is allocated";
}

TEST(PointCloudIo, BadFilesAreNamedInOneLine) {
  const TempFolder folder;
  const auto says = [&](const std::string& name, const std::string& bytes, const std::string& part) {
    const std::string error = cloud_error(write_file(folder, name, bytes));
    EXPECT_NE(error.find(part), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  };
  says("a.pcd", pcd_header("binary", 1 << 14, 1 << 14) + "abc", "truncated");
  says("a.pcd", pcd_header("ascii", 2, 1) + "1 2 3 0 0 1 0\n1 2 x 0 0 1 0\n", "point 1: `x` is not a number");
  says("a.pcd", pcd_header("ascii", 1, 1) + "nan nan nan 0 0 1 0\n", "no point of it is finite");
  says("a.pcd", pcd_header("zip", 1, 1), "data form `zip` is unknown");
  says("a.pcd", "solid cube\n", "is not a PCD file");
  says("a.pcd", "", "empty");
  says("a.ply",
       "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float "
       "z\nend_header\n1 2 3\n",
       "truncated");
  says("a.stl", "solid\n", "no scan format has the extension");
}

TEST(PointCloudIo, PosesOfAConfReadBackAndBadLinesAreNamed) {
  const TempFolder folder;
  const RigidTransform pose{rotation_of(Vec3(0.3, -2.0, 1.0)), Vec3(0.1, 1e-7, -40)};
  write_scan_poses(folder / "a.conf", {{"a.ply", {}}, {"b.ply", pose}});
  const auto back = read_scan_poses(folder / "a.conf");
  ASSERT_EQ(back.size(), 2u);
  EXPECT_EQ(back[1].scan, folder / "b.ply");
  EXPECT_TRUE(back[1].world_from_scan.rotation.isApprox(pose.rotation, 1e-14));
  EXPECT_EQ(back[1].world_from_scan.translation, pose.translation);
  const auto says = [&](const std::string& text, const std::string& part) {
    try {
      (void)read_scan_poses(write_file(folder, "b.conf", text));
      ADD_FAILURE() << text;
    } catch (const IoError& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  };
  says("camera 1 2 3\nbmesh a.ply 0 0 0 0 0 0\n", "line 2: found 8 words");
  says("bmesh a.ply 0 0 0 0 0 0 x\n", "line 1: `x` is not a finite number");
  says("bmesh a.ply 0 0 0 0 0 0 2\n", "length is 2; expected 1");
  says("# nothing\n", "no line begins with `bmesh`");
}

TEST(RealScans, TheBunnysScansLieOnTheirReconstructionWithTheConvention) {
  PATINATE_REQUIRE_DATA(folder, "scans/bunny");
  // The catalog's measurement: 0.53-0.57 mm median from the vertices with R^T, 16-129 mm with R.
  const NearestPoints zipper(read_point_cloud(folder / "reconstruction/bun_zipper.ply").points);
  for (const ScanPose& pose : read_scan_poses(folder / "data/bun.conf")) {
    if (pose.scan.filename() != "bun045.ply" && pose.scan.filename() != "chin.ply") continue;
    const PointCloud cloud = read_point_cloud(pose.scan);
    ASSERT_TRUE(cloud.grid);
    EXPECT_EQ(cloud.grid->width, 512);
    std::vector<double> distances;
    for (std::size_t i = 0; i < cloud.points.size(); i += 50)
      distances.push_back(zipper.nearest(pose.world_from_scan.apply(cloud.points[i])).distance);
    std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                     distances.end());
    EXPECT_GT(distances[distances.size() / 2], 0.50e-3);
    EXPECT_LT(distances[distances.size() / 2], 0.60e-3);
  }
}

TEST(RealScans, KinectCloudsComeWithTheirGridAndWithoutHoles) {
  PATINATE_REQUIRE_DATA(path, "scans/pcl_pairwise/capture0001.pcd");
  const PointCloud cloud = read_point_cloud(path);
  ASSERT_TRUE(cloud.grid);
  EXPECT_EQ(cloud.grid->width, 640);
  EXPECT_EQ(cloud.grid->height, 480);
  EXPECT_LT(cloud.num_points(), 640 * 480);
  EXPECT_GT(cloud.num_points(), 640 * 480 / 2);
  // A pinhole: x / z grows by the same step from column to column.
  const auto point = [&](int x, int y) { return cloud.grid->cell[y * 640 + x]; };
  int seen = 0;
  for (int x = 100; x < 500; x += 50) {
    const int a = point(x, 240), b = point(x + 40, 240);
    if (a < 0 || b < 0) continue;
    const Vec3 pa = cloud.points[a], pb = cloud.points[b];
    EXPECT_NEAR(pb.x() / pb.z() - pa.x() / pa.z(), 40.0 / 525.0, 0.002) << "the Kinect's focal length of 525 px";
    ++seen;
  }
  EXPECT_GT(seen, 2);
}

}  // namespace
}  // namespace patinate
