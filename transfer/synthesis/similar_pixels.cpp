#include "transfer/synthesis/similar_pixels.h"

#include <flann/flann.hpp>

#include <algorithm>
#include <cstdlib>

#include "libcommon/core/parallel.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxSearched = 65'536;
constexpr int kNumAsked = 16;         ///< More than are kept: pixels next to each other look alike and say nothing new.
constexpr int kMinDistance_px = 5;
constexpr int kFeatureSize = kAppearanceSize + 1;

/// Appearance, and the first control on a scale where its spread weighs like one strong component.
void fill_feature(const SourceLevel& source, std::int32_t pixel, float* feature) {
  for (int k = 0; k < kAppearanceSize; ++k) feature[k] = source.appearance.data()[std::int64_t{pixel} * kAppearanceSize + k];
  constexpr float kControlScale = 200.0f / kControlSteps;
  feature[kAppearanceSize] = kControlScale * static_cast<float>(source.controls.data()[std::int64_t{pixel} * source.controls.channels()]);
}

bool is_apart(const SourceLevel& source, std::int32_t a, std::int32_t b) {
  return std::abs(a % source.width() - b % source.width()) >= kMinDistance_px ||
         std::abs(a / source.width() - b / source.width()) >= kMinDistance_px;
}

}  // namespace

SimilarPixels find_similar_pixels(const SourceLevel& source, const RunControl& control) {
  std::vector<std::int32_t> searched;
  const std::size_t step = (source.usable.size() + kMaxSearched - 1) / kMaxSearched;
  for (std::size_t i = 0; i < source.usable.size(); i += step) searched.push_back(source.usable[i]);
  std::vector<float> features(searched.size() * kFeatureSize);
  for (std::size_t i = 0; i < searched.size(); ++i) fill_feature(source, searched[i], features.data() + i * kFeatureSize);
  const flann::Matrix<float> points(features.data(), searched.size(), kFeatureSize);
  flann::Index<flann::L2<float>> index(points, flann::KDTreeSingleIndexParams(16));
  index.buildIndex();

  SimilarPixels similar(source.is_usable.size());
  for (auto& s : similar) s.fill(-1);
  const std::size_t num_asked = std::min<std::size_t>(kNumAsked, searched.size());
  parallel_for(static_cast<std::int64_t>(source.usable.size()), 512, control, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> query(kFeatureSize), distance(num_asked);
    std::vector<int> found(num_asked);
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int32_t pixel = source.usable[static_cast<std::size_t>(i)];
      fill_feature(source, pixel, query.data());
      flann::Matrix<int> indices(found.data(), 1, num_asked);
      flann::Matrix<float> distances(distance.data(), 1, num_asked);
      const flann::Matrix<float> queries(query.data(), 1, kFeatureSize);
      index.knnSearch(queries, indices, distances, num_asked, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
      std::size_t kept = 0;
      for (std::size_t k = 0; k < num_asked && kept < kNumSimilar; ++k) {
        const std::int32_t other = searched[static_cast<std::size_t>(found[k])];
        if (is_apart(source, pixel, other)) similar[static_cast<std::size_t>(pixel)][kept++] = other;
      }
    }
  });
  return similar;
}

SimilarPixels refine_similar_pixels(const SimilarPixels& coarse, const SourceLevel& coarse_source,
                                    const SourceLevel& fine_source) {
  SimilarPixels fine(fine_source.is_usable.size());
  for (auto& s : fine) s.fill(-1);
  for (std::int32_t pixel : fine_source.usable) {
    const int x = pixel % fine_source.width(), y = pixel / fine_source.width();
    const int px = std::min(x / 2, coarse_source.width() - 1), py = std::min(y / 2, coarse_source.height() - 1);
    const auto& parents = coarse[static_cast<std::size_t>(py * coarse_source.width() + px)];
    std::size_t kept = 0;
    for (std::int32_t parent : parents) {
      if (parent < 0) continue;
      const int fx = 2 * (parent % coarse_source.width()) + x % 2, fy = 2 * (parent / coarse_source.width()) + y % 2;
      if (fx >= fine_source.width() || fy >= fine_source.height()) continue;
      const std::int32_t candidate = fy * fine_source.width() + fx;
      if (fine_source.is_usable[static_cast<std::size_t>(candidate)] != 0) {
        fine[static_cast<std::size_t>(pixel)][kept++] = candidate;
      }
    }
  }
  return fine;
}

}  // namespace patinate
