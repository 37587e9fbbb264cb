#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate {

namespace {

constexpr std::uint64_t kMaxBytes = 1 << 20;

std::vector<std::string> pose_words(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t begin = line.find_first_not_of(" \t\r"); begin != std::string_view::npos;
       begin = line.find_first_not_of(" \t\r")) {
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    words.emplace_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

}  // namespace

std::vector<ScanPose> read_scan_poses(const std::filesystem::path& path) {
  const std::string text = read_file(path, kMaxBytes);
  std::vector<ScanPose> poses;
  int number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::vector<std::string> words = pose_words(rest.substr(0, std::min(end, rest.find('#'))));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++number;
    if (words.empty() || words[0] != "bmesh") continue;
    const auto fail = [&](const std::string& problem) {
      throw IoError(path.string(), "line " + std::to_string(number) + ": " + problem);
    };
    if (words.size() != 9)
      fail("found " + std::to_string(words.size()) + " words; expected bmesh FILE tx ty tz qx qy qz qw");
    std::array<double, 7> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
      const std::optional<double> value = parse_number(words[i + 2]);
      if (!value) fail("`" + words[i + 2] + "` is not a finite number");
      v[i] = *value;
    }
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!(std::abs(q.norm() - 1.0) < 1e-3))
      fail("the quaternion's length is " + short_number_text(q.norm()) + "; expected 1");
    ScanPose pose;
    pose.scan = path.parent_path() / words[1];
    pose.world_from_scan = {q.normalized().toRotationMatrix().transpose(), Vec3(v[0], v[1], v[2])};
    poses.push_back(std::move(pose));
  }
  if (poses.empty())
    throw IoError(path.string(), "no line begins with `bmesh`; expected bmesh FILE tx ty tz qx qy qz qw");
  return poses;
}

void write_scan_poses(const std::filesystem::path& path, const std::vector<ScanPose>& poses) {
  std::string text;
  for (const ScanPose& pose : poses) {
    const std::string name = pose.scan.generic_string();
    if (name.empty() || name.find_first_of(" \t\r\n#") != std::string::npos) {
      throw InvalidInput("write_scan_poses: a .conf cannot hold the name `" + name +
                         "`; it must have no blank and no #");
    }
    const Eigen::Quaterniond q(Eigen::Matrix3d(pose.world_from_scan.rotation.transpose()));
    text += "bmesh " + name;
    for (const double value : {pose.world_from_scan.translation.x(), pose.world_from_scan.translation.y(),
                               pose.world_from_scan.translation.z(), q.x(), q.y(), q.z(), q.w()}) {
      text += ' ' + number_text(value);
    }
    text += '\n';
  }
  write_atomically(path, text);
}

}  // namespace patinate
