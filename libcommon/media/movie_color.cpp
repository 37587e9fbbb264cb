#include "libcommon/media/movie_color.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "patinate/core/error.h"
#include "patinate/image/color.h"

extern "C" {
#include <libavcodec/codec_par.h>
#include <libavutil/pixdesc.h>
}

namespace patinate {

namespace {

constexpr double kIdentity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
/// [ITU-R BT.2087-0, section 3.1, inverted].
constexpr double kFrom2020[9] = {1.660491,  -0.587641, -0.072850, -0.124550, 1.132900,
                                 -0.008349, -0.018151, -0.100579, 1.118730};
/// From P3 with the white of D65, by its chromaticities [SMPTE EG 432-1].
constexpr double kFromP3[9] = {1.224940, -0.224940, 0.0, -0.042057, 1.042057, 0.0, -0.019638, -0.078636, 1.098274};

double linear_of_hlg(double code) {
  constexpr double a = 0.17883277, b = 0.28466892, c = 0.55991073;  // Constants as BT.2100 names them.
  const auto scene = [&](double e) { return e <= 0.5 ? e * e / 3.0 : (std::exp((e - c) / a) + b) / 12.0; };
  constexpr double kWhiteCode = 0.75;
  return scene(code) / scene(kWhiteCode);
}

double linear_of_pq(double code) {
  constexpr double m1 = 2610.0 / 16384.0, m2 = 2523.0 / 32.0, c1 = 3424.0 / 4096.0, c2 = 2413.0 / 128.0,
                   c3 = 2392.0 / 128.0;
  constexpr double kPeak = 10000.0, kWhite = 203.0;  // cd/m2.
  const double p = std::pow(code, 1.0 / m2);
  return std::pow(std::max(0.0, p - c1) / (c2 - c3 * p), 1.0 / m1) * kPeak / kWhite;
}

bool is_usual(AVColorTransferCharacteristic transfer) {
  constexpr std::array kUsual{
      AVCOL_TRC_UNSPECIFIED, AVCOL_TRC_RESERVED0,    AVCOL_TRC_RESERVED,     AVCOL_TRC_BT709,     AVCOL_TRC_SMPTE170M,
      AVCOL_TRC_SMPTE240M,   AVCOL_TRC_IEC61966_2_4, AVCOL_TRC_IEC61966_2_1, AVCOL_TRC_BT2020_10, AVCOL_TRC_BT2020_12};
  return std::find(kUsual.begin(), kUsual.end(), transfer) != kUsual.end();
}

/// Rec. 601 and 709 differ by less than cameras do.
bool is_usual(AVColorPrimaries primaries) {
  constexpr std::array kUsual{AVCOL_PRI_UNSPECIFIED, AVCOL_PRI_RESERVED0, AVCOL_PRI_RESERVED, AVCOL_PRI_BT709,
                              AVCOL_PRI_BT470BG,     AVCOL_PRI_SMPTE170M, AVCOL_PRI_SMPTE240M};
  return std::find(kUsual.begin(), kUsual.end(), primaries) != kUsual.end();
}

float linear_of(int transfer, double code) {
  switch (transfer) {
    case AVCOL_TRC_ARIB_STD_B67:
      return static_cast<float>(linear_of_hlg(code));
    case AVCOL_TRC_SMPTE2084:
      return static_cast<float>(linear_of_pq(code));
    case AVCOL_TRC_LINEAR:
      return static_cast<float>(code);
    case AVCOL_TRC_GAMMA22:
      return static_cast<float>(std::pow(code, 2.2));
    case AVCOL_TRC_GAMMA28:
      return static_cast<float>(std::pow(code, 2.8));
    default:
      return linear_from_srgb(static_cast<float>(code));
  }
}

bool is_undone(AVColorTransferCharacteristic transfer) {
  return transfer == AVCOL_TRC_ARIB_STD_B67 || transfer == AVCOL_TRC_SMPTE2084 || transfer == AVCOL_TRC_LINEAR ||
         transfer == AVCOL_TRC_GAMMA22 || transfer == AVCOL_TRC_GAMMA28;
}

bool is_undone(AVColorPrimaries primaries) { return primaries == AVCOL_PRI_BT2020 || primaries == AVCOL_PRI_SMPTE432; }

std::string text_of(const char* name) { return name == nullptr ? "an unknown one" : name; }

/// YCgCo, ICtCp, constant luminance: what libswscale would take for something else.
void check_matrix(const AVCodecParameters& movie) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(movie.format));
  if (format != nullptr && (format->flags & AV_PIX_FMT_FLAG_RGB) != 0) return;
  constexpr std::array kKnown{AVCOL_SPC_UNSPECIFIED, AVCOL_SPC_RESERVED,  AVCOL_SPC_BT709,     AVCOL_SPC_FCC,
                              AVCOL_SPC_BT470BG,     AVCOL_SPC_SMPTE170M, AVCOL_SPC_SMPTE240M, AVCOL_SPC_BT2020_NCL};
  if (std::find(kKnown.begin(), kKnown.end(), movie.color_space) != kKnown.end()) return;
  throw InvalidInput("has the color matrix " + text_of(av_color_space_name(movie.color_space)) +
                     ", which is not read; convert it to BT.709");
}

}  // namespace

MovieLight::MovieLight(int transfer, int primaries) {
  constexpr int kNumCodes = 65536;
  for (int code = 0; code < kNumCodes; ++code)
    linear_.push_back(linear_of(transfer, static_cast<double>(code) / (kNumCodes - 1)));
  const double* matrix = primaries == AVCOL_PRI_BT2020     ? kFrom2020
                         : primaries == AVCOL_PRI_SMPTE432 ? kFromP3
                                                           : kIdentity;
  std::copy_n(matrix, 9, matrix_);
}

void MovieLight::convert(const std::uint16_t* codes, std::size_t num_pixels, int channels, float* light) const {
  for (std::size_t i = 0; i < num_pixels; ++i, codes += channels, light += channels) {
    for (int row = 0; row < 3; ++row) {
      double sum = 0.0;
      for (int k = 0; k < 3; ++k) sum += matrix_[3 * row + k] * static_cast<double>(linear_[codes[k]]);
      light[row] = static_cast<float>(std::max(0.0, sum));
    }
    if (channels == 4) light[3] = static_cast<float>(codes[3]) / 65535.0f;
  }
}

std::optional<MovieLight> movie_light(const AVCodecParameters& movie) {
  check_matrix(movie);
  if (!is_usual(movie.color_trc) && !is_undone(movie.color_trc)) {
    throw InvalidInput("has the transfer " + text_of(av_color_transfer_name(movie.color_trc)) +
                       ", which is not read; convert it to sRGB or BT.709");
  }
  if (!is_usual(movie.color_primaries) && !is_undone(movie.color_primaries)) {
    throw InvalidInput("has the primaries " + text_of(av_color_primaries_name(movie.color_primaries)) +
                       ", which are not read; convert it to BT.709");
  }
  if (is_usual(movie.color_trc) && is_usual(movie.color_primaries)) return std::nullopt;
  return MovieLight(movie.color_trc, movie.color_primaries);
}

std::string movie_color_text(const AVCodecParameters& movie) {
  if (is_usual(movie.color_trc) && is_usual(movie.color_primaries)) return "";
  const std::string transfer = movie.color_trc == AVCOL_TRC_ARIB_STD_B67 ? "HLG"
                               : movie.color_trc == AVCOL_TRC_SMPTE2084  ? "PQ"
                               : is_usual(movie.color_trc)               ? "sRGB"
                                                           : text_of(av_color_transfer_name(movie.color_trc));
  const std::string primaries = movie.color_primaries == AVCOL_PRI_BT2020     ? "BT.2020"
                                : movie.color_primaries == AVCOL_PRI_SMPTE432 ? "Display P3"
                                                                              : "BT.709";
  return transfer + " with " + primaries + " colors, made linear Rec. 709";
}

}  // namespace patinate
