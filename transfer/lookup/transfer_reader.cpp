#include "transfer/lookup/transfer_reader.h"

#include <algorithm>
#include <cmath>

#include "libcommon/atlas/dilate.h"
#include "libcommon/core/parallel.h"
#include "libcommon/geometry/mesh_io.h"
#include "libcommon/image/image_io.h"

namespace patinate {

namespace {

void check_coordinates(const std::filesystem::path& file, const ImageF& coordinates, const HistoryManifest& history) {
  for (int y = 0; y < coordinates.height(); ++y) {
    for (int x = 0; x < coordinates.width(); ++x) {
      const float sx = coordinates.at(x, y, 0), sy = coordinates.at(x, y, 1);
      if (sx == -1.0f && sy == -1.0f) continue;
      const bool is_inside = sx >= 0.0f && sy >= 0.0f && sx < static_cast<float>(history.width) && sy < static_cast<float>(history.height);
      if (!is_inside || sx != std::floor(sx) || sy != std::floor(sy)) {
        throw IoError(file.string(), "texel (" + std::to_string(x) + ", " + std::to_string(y) +
                                         ") points outside the history or between its pixels; make the transfer again");
      }
    }
  }
}

}  // namespace

ImageF gather(const ImageF& source, const ImageF& coordinates, float outside, const RunControl& control) {
  ImageF result(coordinates.width(), coordinates.height(), source.channels(), outside);
  const auto channels = static_cast<std::size_t>(source.channels());
  parallel_for(coordinates.height(), 64, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const auto row = coordinates.row(y);
      const auto out = result.row(y);
      for (std::size_t x = 0; x < static_cast<std::size_t>(result.width()); ++x) {
        if (row[2 * x] < 0.0f) continue;
        const auto from = source.pixel(static_cast<int>(row[2 * x]), static_cast<int>(row[2 * x + 1]));
        std::copy_n(from.begin(), channels, out.begin() + static_cast<std::ptrdiff_t>(channels * x));
      }
    }
  });
  return result;
}

TransferReader::TransferReader(const std::filesystem::path& path)
    : manifest_(read_transfer_manifest(path)),
      history_(manifest_.history),
      mesh_(with_normals(read_mesh(manifest_.mesh))),
      coordinates_(read_channels(manifest_.coordinates, {kCoordinateChannels[0], kCoordinateChannels[1]})) {
  if (history_content_key(history_) != manifest_.history_key) {
    throw IoError(manifest_.history.string(), "is not the history that " + path.string() + " was made from; make the transfer again");
  }
  if (coordinates_.width() != manifest_.width || coordinates_.height() != manifest_.height) {
    throw IoError(manifest_.coordinates.string(), "is " + std::to_string(coordinates_.width()) + " x " + std::to_string(coordinates_.height()) +
                                                      "; expected " + std::to_string(manifest_.width) + " x " + std::to_string(manifest_.height));
  }
  check_coordinates(manifest_.coordinates, coordinates_, history_.manifest());
}

ImageU8 TransferReader::coverage() const {
  ImageU8 coverage(coordinates_.width(), coordinates_.height());
  for (int y = 0; y < coverage.height(); ++y) {
    for (int x = 0; x < coverage.width(); ++x) coverage.at(x, y) = coordinates_.at(x, y, 0) >= 0.0f ? 255 : 0;
  }
  return coverage;
}

ImageF TransferReader::sample(double time, const RunControl& control) const {
  // Blending the two frames first equals blending two lookups, and touches fewer texels.
  ImageF result = gather(history_.sample(time), coordinates_, 0.0f, control);
  dilate(result, coverage(), -1);
  return result;
}

}  // namespace patinate
