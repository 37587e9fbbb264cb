#include "capture/unlighting/response_check.h"

#include "capture/unlighting/leave_one_out.h"
#include "capture/unlighting/unlight_work.h"
#include "libcommon/core/median.h"

namespace patinate::capture {

namespace {

constexpr std::int64_t kMaxCheckedTexels = 2'000;  ///< Texels that are predicted, evenly picked.

/// The chosen texels as an image of one row. Samples in cast shadows are not valid, so that nothing need cast them
/// again.
UnlightInput row_of(const UnlightWork& work, const std::vector<std::int64_t>& texels) {
  const UnlightInput& in = work.input;
  const int n = static_cast<int>(texels.size());
  UnlightInput row{.lights = in.lights, .view_direction = in.view_direction};
  if (!in.normal.empty()) row.normal = ImageF(n, 1, 3);
  if (!in.position_mm.empty()) row.position_mm = ImageF(n, 1, 3);
  row.photos.assign(in.photos.size(), ImageF(n, 1, work.num_channels));
  row.valid.assign(in.photos.size(), ImageU8(n, 1));
  for (int i = 0; i < n; ++i) {
    const auto at = texels[i];
    const int x = static_cast<int>(at % work.width), y = static_cast<int>(at / work.width);
    for (int c = 0; c < 3; ++c) {
      if (!in.normal.empty()) row.normal.at(i, 0, c) = work.normal.at(x, y, c);
      if (!in.position_mm.empty()) row.position_mm.at(i, 0, c) = in.position_mm.at(x, y, c);
    }
    for (std::size_t k = 0; k < in.photos.size(); ++k) {
      const bool is_clean = work.samples.at(x, y, static_cast<int>(k)) == static_cast<std::uint8_t>(SampleState::Clean);
      row.valid[k].at(i, 0) = is_clean ? 255 : 0;
      for (int c = 0; c < work.num_channels; ++c) row.photos[k].at(i, 0, c) = in.photos[k].at(x, y, c);
    }
  }
  return row;
}

/// Values as the other curve would have decoded them.
void decode_otherwise(UnlightInput& row, const std::vector<float>& ambient, bool is_linear) {
  const auto other = [&](float v) { return is_linear ? linear_from_srgb(v) : srgb_from_linear(v); };
  for (ImageF& photo : row.photos) {
    for (std::size_t i = 0; i < photo.values().size(); ++i) {
      float& v = photo.values()[i];
      const float dark = ambient.empty() ? 0.0f : ambient[i];
      v = other(v + dark) - other(dark);
    }
  }
}

/// Median over lamps of how far off their photographs are when the others predict them; no shadow or highlight moves
/// it.
double predicted_error(const UnlightInput& row, const RunControl& control) {
  const UnlightOptions options{.specular = SpecularMode::None};
  const UnlightResult result = unlight(row, options, control.part(0.0, 0.3));
  std::vector<double> errors;
  for (const LeaveOneOutError& e : leave_one_out(row, options, result, control.part(0.3, 1.0))) {
    if (e.num_samples > 0) errors.push_back(e.median);
  }
  return median(std::move(errors));
}

}  // namespace

ResponseCheck check_response(const UnlightInput& input, const ImageF& ambient, const Response& declared,
                             const RunControl& control) {
  // Ratio of errors, least relative error, and the other response's gamma.
  constexpr double kMuchBetter = 0.6, kSurelyOff = 0.02, kPower = 2.2;
  const UnlightOptions options;
  const UnlightWork work(input, options, control.part(0.0, 0.4));
  const std::vector<std::int64_t> texels = work.spread_texels(kMaxCheckedTexels);
  UnlightInput row = row_of(work, texels);
  std::vector<float> dark;
  for (std::size_t i = 0; i < texels.size() && !ambient.empty(); ++i) {
    const auto pixel =
        ambient.pixel(static_cast<int>(texels[i] % work.width), static_cast<int>(texels[i] / work.width));
    dark.insert(dark.end(), pixel.begin(), pixel.end());
  }
  ResponseCheck check{.as_declared = predicted_error(row, control.part(0.4, 0.7))};
  // In shares of the same values: sRGB codes are about the 1/2.2th power of light.
  const bool is_linear = declared.kind == Response::Kind::Linear;
  decode_otherwise(row, dark, is_linear);
  check.otherwise = (is_linear ? 1.0 / kPower : kPower) * predicted_error(row, control.part(0.7, 1.0));
  check.is_doubtful = check.as_declared > kSurelyOff && check.otherwise < kMuchBetter * check.as_declared;
  return check;
}

}  // namespace patinate::capture
