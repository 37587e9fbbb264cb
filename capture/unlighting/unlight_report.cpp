#include "capture/unlighting/unlight_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::array<const char*, kNumSampleStates> kStateNames{"outside", "clean",  "unlit",   "cast_shadow",
                                                                "invalid", "darker", "brighter"};

float percentile_of(const ImageF& map, const ImageU8& mask, double rank) {
  std::vector<float> values;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      const auto pixel = map.pixel(x, y);
      values.push_back(*std::max_element(pixel.begin(), pixel.end()));
    }
  }
  if (values.empty()) return 0.0f;
  return value_at_rank(values, static_cast<std::size_t>(rank * static_cast<double>(values.size() - 1)));
}

/// One channel as gray, `white` becoming 1.
ImageF gray_picture(const ImageF& map, int channel, double white) {
  ImageF out(map.width(), map.height(), 3);
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      const auto v = static_cast<float>(std::clamp(static_cast<double>(map.at(x, y, channel)) / white, 0.0, 1.0));
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = v;
    }
  }
  return out;
}

/// Standard deviation over albedo, of the channel where it is largest.
ImageF relative_stddev(const UnlightResult& result) {
  ImageF out(result.albedo.width(), result.albedo.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      for (int c = 0; c < result.albedo.channels(); ++c) {
        const float a = result.albedo.at(x, y, c);
        if (a > 0.0f) out.at(x, y) = std::max(out.at(x, y), result.stddev.at(x, y, c) / a);
      }
    }
  }
  return out;
}

}  // namespace

std::string samples_file(std::size_t light) {
  const std::string number = std::to_string(light + 1);
  return "samples/" + (number.size() < 2 ? "0" : std::string()) + number + ".png";
}

std::string sample_state_name(SampleState state) { return kStateNames[static_cast<std::size_t>(state)]; }

std::array<float, 3> sample_state_color(SampleState state) {
  constexpr std::array<std::array<float, 3>, kNumSampleStates> kColors{{{0.2f, 0.2f, 0.2f},
                                                                        {0.6f, 0.6f, 0.58f},
                                                                        {0.0f, 0.0f, 0.0f},
                                                                        {0.05f, 0.1f, 0.8f},
                                                                        {0.8f, 0.0f, 0.6f},
                                                                        {0.0f, 0.6f, 0.7f},
                                                                        {0.9f, 0.05f, 0.02f}}};
  return kColors[static_cast<std::size_t>(state)];
}

ImageF samples_picture(const UnlightInput& input, const UnlightResult& result, int light) {
  const ImageF& photo = input.photos[light];
  const float white = std::max(1e-9f, percentile_of(photo, result.mask, 0.99));
  ImageF out(photo.width(), photo.height(), 3);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const auto state = static_cast<SampleState>(result.samples.at(x, y, light));
      const std::array<float, 3> color = sample_state_color(state);
      const float gray = std::clamp(luminance(photo.pixel(x, y)) / white, 0.0f, 1.0f);
      for (std::size_t c = 0; c < 3; ++c) {
        out.at(x, y, static_cast<int>(c)) = state == SampleState::Clean ? gray : color[c];
      }
    }
  }
  return out;
}

ImageU8 normal_picture(const UnlightResult& result, const Eigen::Matrix3d& camera_from_world) {
  ImageU8 out(result.normal.width(), result.normal.height(), 3);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const auto p = result.normal.pixel(x, y);
      const Vec3 n(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
      if (!(n.squaredNorm() > 0.0)) continue;
      const Vec3 seen = Vec3(1, -1, -1).asDiagonal() * (camera_from_world * n);
      for (int c = 0; c < 3; ++c)
        out.at(x, y, c) = static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::clamp(seen[c], -1.0, 1.0)));
    }
  }
  return out;
}

ImageF color_picture(const ImageF& map, double& factor) {
  const float high = percentile_of(map, {}, 0.995);
  factor = high > 1.0f ? 0.9 / static_cast<double>(high) : 1.0;
  ImageF out(map.width(), map.height(), 3);
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      for (int c = 0; c < 3; ++c)
        out.at(x, y, c) = static_cast<float>(factor) * map.at(x, y, map.channels() == 1 ? 0 : c);
    }
  }
  return out;
}

void write_unlight_report(const fs::path& folder, const std::string& name, const UnlightInput& input,
                          const UnlightResult& result, const std::vector<LeaveOneOutError>& predicted,
                          const Eigen::Matrix3d& camera_from_world) {
  constexpr double kStddevWhite = 0.1;  // Relative deviation that is white in the picture.
  fs::create_directories(folder / "samples");
  double factor = 1.0;
  write_srgb8(folder / "albedo.png", color_picture(result.albedo, factor));
  write_codes(folder / "normal.png", normal_picture(result, camera_from_world));
  write_srgb8(folder / "stddev.png", gray_picture(relative_stddev(result), 0, kStddevWhite));
  HtmlPage page("Unlighting" + (name.empty() ? "" : ": " + name));
  page.paragraph(
      std::to_string(result.num_determined) + " of " + std::to_string(result.num_surface) + " texels are determined (" +
      percent_text(static_cast<double>(result.num_determined) /
                   static_cast<double>(std::max<std::int64_t>(1, result.num_surface))) +
      "). Clean samples are off by " + percent_text(result.residual) + " (root mean square, over their mean).");
  for (const std::string& note : result.notes) page.paragraph("Note: " + note + ".");
  std::vector<HtmlPicture> maps{
      {"albedo.png", factor == 1.0 ? "albedo" : "albedo times " + short_number_text(rounded(factor, 3))},
      {"normal.png", "normals: red right, green up, blue to the camera"},
      {"stddev.png", "standard deviation of the albedo: white is " + percent_text(kStddevWhite) + " of it and more"}};
  if (!result.specular.empty()) {
    const double white = std::max(1e-3, static_cast<double>(percentile_of(result.specular, result.mask, 0.99)));
    write_srgb8(folder / "specular.png", gray_picture(result.specular, 0, std::min(1.0, white)));
    maps.push_back({"specular.png",
                    "strength of the highlight (F0): white is " + short_number_text(rounded(std::min(1.0, white), 2))});
  }
  page.pictures(maps);
  page.heading("Lamps");
  page.paragraph(
      "Leave-one-out: each photograph predicted from the others. RMS over clean samples; the median is over all lit "
      "ones, rejected ones too.");
  std::vector<std::vector<std::string>> rows;
  std::vector<HtmlPicture> samples;
  for (std::size_t k = 0; k < result.lights.size(); ++k) {
    const LightReport& light = result.lights[k];
    const auto share = [&](SampleState s) {
      return percent_text(static_cast<double>(light.samples[static_cast<std::size_t>(s)]) /
                          static_cast<double>(std::max<std::int64_t>(1, result.num_surface)));
    };
    const std::string title =
        input.lights[k].name.empty() ? std::to_string(k + 1) : std::to_string(k + 1) + " " + input.lights[k].name;
    rows.push_back({title, share(SampleState::Clean), share(SampleState::Unlit), share(SampleState::CastShadow),
                    share(SampleState::Darker), share(SampleState::Brighter), share(SampleState::Invalid),
                    short_number_text(rounded(light.strength.mean(), 4)), percent_text(light.residual),
                    percent_text(predicted[k].rms), percent_text(predicted[k].median)});
    write_srgb8(folder / samples_file(k), samples_picture(input, result, static_cast<int>(k)));
    samples.push_back({samples_file(k), title});
  }
  page.table({"lamp", "clean", "faces away", "cast shadow", "darker", "brighter", "not valid", "strength", "residual",
              "leave-one-out RMS", "leave-one-out median"},
             rows);
  page.heading("Samples");
  page.paragraph(
      "Gray: clean. Black: the surface faces away. Blue: in a cast shadow. Cyan: darker than the other lamps allow. "
      "Red: brighter (a highlight). Magenta: saturated or out of view.");
  page.pictures(samples);
  page.save(folder / "report.html");
}

}  // namespace patinate::capture
