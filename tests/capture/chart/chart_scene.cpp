#include "tests/capture/chart/chart_scene.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/chart/chart_table.h"
#include "libcommon/core/random.h"
#include "patinate/image/color.h"
#include "patinate/metrics/difference.h"
#include "tests/capture/chart/chart_spectra.h"

namespace patinate::testing_support {

namespace {

using capture::ChartTable;
using capture::kChartColumns;
using capture::kChartRows;
using capture::kPatchSide;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFrame = 0.35;       ///< Width of the chart's frame, in distances of two patches.
constexpr int kSamples = 3;           ///< A side, of a pixel.
constexpr double kWhiteLight = 0.5;   ///< Share of the largest light.
constexpr double kChartWidth = 0.36;  ///< Share of the picture's width, for six patches.
constexpr double kDegrees = std::numbers::pi / 180.0;

/// Uniform in [low, high).
double draw(RandomStream& random, double low, double high) { return low + (high - low) * random.uniform(); }

/// A camera under a lamp: what it makes of surfaces.
class Camera {
 public:
  explicit Camera(const ChartScene& scene) : kind_(scene.camera) {
    const Spectrum lamp = lamp_spectrum(scene.lamp);
    const std::array<Spectrum, 3> sensitivities = camera_spectra(scene.camera);
    for (std::size_t c = 0; c < 3; ++c) {
      const Spectrum light = lamp * sensitivities[c];
      weights_[c] = light / light.sum();  // White balance: gray is gray.
    }
    if (scene.camera != 0) set_color_matrix();
  }

  /// The sensor's light of a surface, in which white is 1.
  [[nodiscard]] Vector3d sensor(const Spectrum& reflectance) const {
    return {(reflectance * weights_[0]).sum(), (reflectance * weights_[1]).sum(), (reflectance * weights_[2]).sum()};
  }

  /// Codes of the sensor's light after white balance, in [0, 1].
  [[nodiscard]] Vector3d codes(const Vector3d& sensor) const {
    Vector3d codes = (to_output_ * sensor.cwiseMin(1.0)).cwiseMax(0.0).cwiseMin(1.0);
    const double largest = kind_ == 0 ? 65535.0 : 255.0;
    for (double& v : codes) {
      if (kind_ != 0) v = static_cast<double>(srgb_from_linear(static_cast<float>(v)));
      if (kind_ == 2) v = 0.65 * v + 0.35 * v * v * (3.0 - 2.0 * v);  // A tone curve: more contrast in the middle.
      v = std::round(largest * v) / largest;
    }
    return codes;
  }

 private:
  /// Matrix as makers choose it: least squares to Rec. 709 over the chart, gray stays gray; and a little too colorful.
  void set_color_matrix() {
    const ChartTable table = capture::classic_chart(capture::ChartEdition::Since2014);
    Eigen::MatrixXd seen(24, 3), wanted(24, 3);
    for (int i = 0; i < 24; ++i) {
      const auto& patch = table[static_cast<std::size_t>(i)];
      seen.row(i) = sensor(surface_of_lab(patch.lab)).transpose();
      wanted.row(i) = Vector3d(patch.linear.data()).transpose();
    }
    to_output_ = seen.colPivHouseholderQr().solve(wanted).transpose();
    const double more = kind_ == 2 ? 0.15 : 0.0;
    to_output_ =
        (1.0 + more) * to_output_ - more / 3.0 * Vector3d::Ones() * (Vector3d::Ones().transpose() * to_output_);
    for (int i = 0; i < 3; ++i) to_output_.row(i) /= to_output_.row(i).sum();
  }

  int kind_;
  std::array<Spectrum, 3> weights_;
  Matrix3d to_output_ = Matrix3d::Identity();
};

/// Everything that is drawn of a scene.
struct Layout {
  Matrix3d photo_from_cell = Matrix3d::Identity();  ///< Transform of the chart's columns and rows.
  std::vector<Spectrum> chart;                      ///< Surfaces of the patches.
  Spectrum frame, table, cover;
  std::vector<KnownPatch> patches;
  std::vector<Spectrum> surfaces;  ///< Spectra of `patches`.
  Vector2d slope = Vector2d::Zero();
  double bend = 0.0;
  Eigen::Array4d covered{0, 0, 0, 0};  ///< Cells from, to: columns, then rows.
};

Matrix3d draw_view(const ChartScene& scene, RandomStream& random) {
  const double turn = draw(random, -1.0, 1.0) * scene.largest_turn_deg * kDegrees;
  const double axis = draw(random, 0.0, 2.0 * std::numbers::pi);
  Matrix3d middle = Matrix3d::Identity();  // The chart's middle is 0.
  middle(0, 2) = -0.5 * (kChartColumns - 1);
  middle(1, 2) = -0.5 * (kChartRows - 1);
  const Matrix3d turned =
      Eigen::AngleAxisd(scene.tilt_deg * kDegrees, Vector3d(std::cos(axis), std::sin(axis), 0.0)).toRotationMatrix() *
      Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
  constexpr double kDistance = 18.0;  // Three widths of the chart.
  Matrix3d view;
  view << turned.col(0), turned.col(1), Vector3d(0.0, 0.0, kDistance);
  const double zoom = kChartWidth * scene.width / kChartColumns * kDistance;
  Matrix3d camera;
  camera << zoom, 0, 0.29 * scene.width, 0, zoom, 0.5 * scene.height, 0, 0, 1;
  return camera * view * middle;
}

void draw_patches(const ChartScene& scene, RandomStream& random, Layout& layout) {
  constexpr int kColumns = 4, kRows = 6;
  const int step = static_cast<int>(0.095 * scene.width), side = step * 4 / 5;
  for (int i = 0; i < kColumns * kRows; ++i) {
    const double lightness = draw(random, 25.0, 90.0), hue = draw(random, 0.0, 2.0 * std::numbers::pi);
    const double chroma = draw(random, 0.0, 45.0 * (1.0 - std::abs(lightness - 55.0) / 55.0));
    const Spectrum smooth = surface_of_lab({lightness, chroma * std::cos(hue), chroma * std::sin(hue)});
    layout.surfaces.push_back(rippled(smooth, 0.1, draw(random, 0.0, 6.0)));
    KnownPatch patch{.x = static_cast<int>(0.605 * scene.width) + i % kColumns * step,
                     .y = static_cast<int>(0.5 * scene.height) - 3 * step + i / kColumns * step,
                     .side = side,
                     .lab = lab_of_surface(layout.surfaces.back())};
    patch.linear = linear_from_lab(patch.lab);
    layout.patches.push_back(patch);
  }
}

void spoil(const ChartScene& scene, RandomStream& random, Layout& layout) {
  const ChartTable table = capture::classic_chart(capture::ChartEdition::Since2014);
  if (scene.spoil == ChartSpoil::OtherMake) {
    for (std::size_t i = 0; i < table.size(); ++i) {  // Differences of ten and more.
      const double angle = draw(random, 0.0, 2.0 * std::numbers::pi);
      std::array<double, 3> lab = table[i].lab;
      lab[0] = std::clamp(lab[0] + draw(random, -12.0, 12.0), 15.0, 92.0);
      lab[1] += 18.0 * std::cos(angle);
      lab[2] += 18.0 * std::sin(angle);
      layout.chart[i] = surface_of_lab(lab);
    }
  }
  if (scene.spoil == ChartSpoil::Shuffled)
    std::rotate(layout.chart.begin(), layout.chart.begin() + 7, layout.chart.end());
  if (scene.spoil == ChartSpoil::Bent) layout.bend = draw(random, 0.35, 0.7);
  if (scene.spoil == ChartSpoil::Hidden) {
    const double wide = draw(random, 0.7, 2.5), high = draw(random, 0.7, 2.5);
    const double left = draw(random, -0.5, kChartColumns - 0.5 - wide),
                 top = draw(random, -0.5, kChartRows - 0.5 - high);
    layout.covered = {left, left + wide, top, top + high};
  }
}

Layout draw_layout(const ChartScene& scene) {
  RandomStream random(scene.seed, 0, 901);
  Layout layout;
  layout.photo_from_cell = draw_view(scene, random);
  if (scene.spoil == ChartSpoil::CutOff) {
    Matrix3d away = Matrix3d::Identity();
    away(0, 2) = -draw(random, 0.17, 0.3) * scene.width;
    layout.photo_from_cell = away * layout.photo_from_cell;
  }
  if (scene.spoil == ChartSpoil::Mirrored) {
    Matrix3d flip = Matrix3d::Identity();
    flip(0, 0) = -1.0;
    flip(0, 2) = kChartColumns - 1;
    layout.photo_from_cell = layout.photo_from_cell * flip;
  }
  for (const auto& patch : capture::classic_chart(capture::ChartEdition::Since2014))
    layout.chart.push_back(surface_of_lab(patch.lab));
  layout.frame = Spectrum::Constant(0.035);
  layout.table = surface_of_lab({draw(random, 30.0, 70.0), draw(random, -8.0, 8.0), draw(random, -8.0, 12.0)});
  layout.cover = surface_of_lab({draw(random, 20.0, 80.0), draw(random, -20.0, 20.0), draw(random, -20.0, 20.0)});
  const double angle = draw(random, 0.0, 2.0 * std::numbers::pi);
  layout.slope = scene.slope * random.uniform() * Vector2d(std::cos(angle), std::sin(angle));
  draw_patches(scene, random, layout);
  spoil(scene, random, layout);
  return layout;
}

/// Surface that a place shows: of the chart 0 to 23, then frame, table, cover, and the patches beside it.
int surface_at(const ChartScene& scene, const Layout& layout, const Matrix3d& cell_from_photo, const Vector2d& at) {
  for (std::size_t i = 0; i < layout.patches.size(); ++i) {
    const KnownPatch& p = layout.patches[i];
    if (at.x() >= p.x - 0.5 && at.x() < p.x + p.side - 0.5 && at.y() >= p.y - 0.5 && at.y() < p.y + p.side - 0.5)
      return 27 + static_cast<int>(i);
  }
  if (scene.spoil == ChartSpoil::Absent) return 25;
  Vector2d cell = (cell_from_photo * at.homogeneous()).hnormalized();
  const double along = (cell.x() + 0.5) / kChartColumns;
  cell.y() += layout.bend * 4.0 * along * (1.0 - along);
  const auto& hidden = layout.covered;
  if (cell.x() >= hidden[0] && cell.x() < hidden[1] && cell.y() >= hidden[2] && cell.y() < hidden[3]) return 26;
  const double outer = 0.5 * kPatchSide + kFrame;
  if (cell.x() < -outer || cell.y() < -outer || cell.x() > kChartColumns - 1 + outer ||
      cell.y() > kChartRows - 1 + outer)
    return 25;
  const int column = static_cast<int>(std::lround(cell.x())), row = static_cast<int>(std::lround(cell.y()));
  const bool is_patch = column >= 0 && row >= 0 && column < kChartColumns && row < kChartRows &&
                        std::abs(cell.x() - column) < 0.5 * kPatchSide && std::abs(cell.y() - row) < 0.5 * kPatchSide;
  return is_patch ? row * kChartColumns + column : 24;
}

/// Uneven stone around it, in [0.7, 1.3].
double texture_at(double x, double y, std::uint32_t seed) {
  double sum = 0.0, weight = 0.4;
  for (int octave = 0; octave < 3; ++octave) {
    const double scale = 40.0 / (1 << octave);
    const int x0 = static_cast<int>(std::floor(x / scale)), y0 = static_cast<int>(std::floor(y / scale));
    const double fx = x / scale - x0, fy = y / scale - y0;
    const auto value = [&](int i, int j) {
      return philox4x32({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j),
                         static_cast<std::uint32_t>(octave), seed},
                        {7, 11})[0] /
                 4294967296.0 -
             0.5;
    };
    sum += weight * ((1 - fy) * ((1 - fx) * value(x0, y0) + fx * value(x0 + 1, y0)) +
                     fy * ((1 - fx) * value(x0, y0 + 1) + fx * value(x0 + 1, y0 + 1)));
    weight *= 0.6;
  }
  return 1.0 + sum;
}

}  // namespace

ChartPhoto render_chart(const ChartScene& scene, const ChartExposure& exposure) {
  const Layout layout = draw_layout(scene);
  const Camera camera(scene);
  std::vector<Vector3d> seen;
  for (const Spectrum& surface : layout.chart) seen.push_back(camera.sensor(surface));
  for (const Spectrum* surface : {&layout.frame, &layout.table, &layout.cover}) seen.push_back(camera.sensor(*surface));
  for (const Spectrum& surface : layout.surfaces) seen.push_back(camera.sensor(surface));
  const double spoiled = scene.spoil == ChartSpoil::Dark ? 0.05 : scene.spoil == ChartSpoil::Bright ? 2.6 : 1.0;
  const Vector3d gain = kWhiteLight / 0.9 * spoiled * exposure.exposure * Vector3d(exposure.white_balance.data());
  const Matrix3d cell_from_photo = layout.photo_from_cell.inverse();
  const double half = 0.5 * std::hypot(scene.width, scene.height);
  ChartPhoto photo{.codes = ImageF(scene.width, scene.height, 3), .patches = layout.patches};
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      Vector3d light = Vector3d::Zero();
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const Vector2d at(x + (s % kSamples + 0.5) / kSamples - 0.5, y + (s / kSamples + 0.5) / kSamples - 0.5);
        const int surface = surface_at(scene, layout, cell_from_photo, at);
        const double texture = surface == 25 ? texture_at(at.x(), at.y(), scene.seed) : 1.0;
        light += texture / (kSamples * kSamples) * seen[static_cast<std::size_t>(surface)];
      }
      const Vector2d from_middle((x - 0.5 * (scene.width - 1)) / half, (y - 0.5 * (scene.height - 1)) / half);
      light *= std::exp(-scene.vignetting * from_middle.squaredNorm() + layout.slope.dot(from_middle));
      light = light.cwiseProduct(gain);
      RandomStream random(exposure.noise_seed, static_cast<std::uint64_t>(y) * 65536 + static_cast<std::uint64_t>(x),
                          902);
      for (double& v : light) v += scene.noise * std::sqrt(1e-4 * v + 1e-6) * random.normal();
      const Vector3d codes = camera.codes(light);
      for (int c = 0; c < 3; ++c) photo.codes.at(x, y, c) = static_cast<float>(codes[c]);
    }
  }
  const double low = -0.5 * kPatchSide, right = kChartColumns - 1 - low, bottom = kChartRows - 1 - low;
  const std::array<Vector2d, 4> cells{Vector2d(low, low), Vector2d(right, low), Vector2d(right, bottom),
                                      Vector2d(low, bottom)};
  for (std::size_t i = 0; i < 4; ++i)
    photo.corners[i] = (layout.photo_from_cell * cells[i].homogeneous()).hnormalized();
  return photo;
}

ImageF linear_of(const ChartPhoto& photo, int camera) {
  ImageF linear = photo.codes;
  if (camera == 0) return linear;
  for (float& v : linear.values()) v = linear_from_srgb(v);
  return linear;
}

std::string spoil_text(ChartSpoil spoil) {
  constexpr std::array<const char*, kNumSpoils> kNames{"none",       "hidden", "mirrored", "dark",    "bright",
                                                       "other make", "bent",   "absent",   "cut off", "shuffled"};
  return kNames[static_cast<std::size_t>(spoil)];
}

}  // namespace patinate::testing_support
