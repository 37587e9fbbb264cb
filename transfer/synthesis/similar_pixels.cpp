#include "transfer/synthesis/similar_pixels.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <flann/flann.hpp>

#include "libcommon/core/parallel.h"
#include "transfer/exemplar/principal_components.h"

namespace patinate::transfer {

namespace {

/// Pixels that are searched, evenly picked where a source has more.
constexpr std::size_t kMaxSearched = 65'536;
constexpr int kNumAsked = 40;       ///< More than are kept: pixels next to each other look alike and say nothing new.
constexpr int kMinDistance_px = 5;  ///< Nearer pixels show nearly the same neighborhood.
constexpr float kSlack = 4.0f;  ///< Branches that could hold nothing nearer than 1 / (1 + this) of the worst squared
                                ///< distance are excluded: half of the time, the same textures.
constexpr int kFeatureSize = kAppearanceSize + 1;

constexpr std::array<Offset, 9> kLooked{{{0, 0}, {-2, 0}, {2, 0}, {0, -2}, {0, 2}, {-2, -2}, {2, -2}, {-2, 2}, {2, 2}}};
/// 1, 3/4 and (3/4)^2, by how many axes an offset leaves.
constexpr std::array<double, 9> kLookedWeights{1.0, 0.75, 0.75, 0.75, 0.75, 0.5625, 0.5625, 0.5625, 0.5625};
constexpr std::int64_t kMaxSamples = 4096;  // For the components.

/// Appearance at and around a pixel, weighted.
void look_around(const SourceLevel& source, std::int32_t pixel, double* values) {
  const int x = pixel % source.width(), y = pixel / source.width();
  for (std::size_t k = 0; k < kLooked.size(); ++k) {
    const auto appearance = source.appearance.pixel(std::clamp(x + kLooked[k].x, 0, source.width() - 1),
                                                    std::clamp(y + kLooked[k].y, 0, source.height() - 1));
    for (std::int16_t value : appearance) *values++ = kLookedWeights[k] * value;
  }
}

/// Features that two pixels are compared by: the leading components of what lies around them, and the first control on
/// a scale where its spread weighs like one strong component.
class Features {
 public:
  explicit Features(const SourceLevel& source) : source_(source) {
    const auto n = static_cast<std::int64_t>(source.usable.size()), step = (n + kMaxSamples - 1) / kMaxSamples;
    SampleMatrix samples((n + step - 1) / step, kNumLooked);
    for (std::int64_t i = 0; i < samples.rows(); ++i)
      look_around(source, source.usable[i * step], samples.row(i).data());
    components_ = principal_components(samples, kAppearanceSize);
  }
  void fill(std::int32_t pixel, float* feature) const {
    std::array<double, kNumLooked> around{};
    look_around(source_, pixel, around.data());
    for (int k = 0; k < kAppearanceSize; ++k) {
      double sum = 0.0;
      for (int i = 0; i < kNumLooked; ++i) sum += (around[i] - components_.mean[i]) * components_.axes(i, k);
      feature[k] = static_cast<float>(sum);
    }
    // The control's full range counts as 400 units of appearance.
    constexpr float kControlScale = 400.0f / kControlSteps;
    feature[kAppearanceSize] =
        kControlScale * static_cast<float>(source_.controls.data()[std::int64_t{pixel} * source_.controls.channels()]);
  }

 private:
  static constexpr int kNumLooked = static_cast<int>(kLooked.size()) * kAppearanceSize;
  const SourceLevel& source_;
  PrincipalComponents components_;
};

bool is_apart(const SourceLevel& source, std::int32_t a, std::int32_t b) {
  return std::abs(a % source.width() - b % source.width()) >= kMinDistance_px ||
         std::abs(a / source.width() - b / source.width()) >= kMinDistance_px;
}

}  // namespace

SimilarPixels find_similar_pixels(const SourceLevel& source, const RunControl& control) {
  std::vector<std::int32_t> searched;
  const std::size_t step = (source.usable.size() + kMaxSearched - 1) / kMaxSearched;
  for (std::size_t i = 0; i < source.usable.size(); i += step) searched.push_back(source.usable[i]);
  const Features features_of(source);
  std::vector<float> features(searched.size() * kFeatureSize);
  for (std::size_t i = 0; i < searched.size(); ++i) features_of.fill(searched[i], features.data() + i * kFeatureSize);
  const flann::Matrix<float> points(features.data(), searched.size(), kFeatureSize);
  flann::Index<flann::L2<float>> index(points, flann::KDTreeSingleIndexParams(16));
  index.buildIndex();

  SimilarPixels similar(source.is_usable.size());
  for (auto& s : similar) s.fill(-1);
  const std::size_t num_asked = std::min<std::size_t>(kNumAsked, searched.size());
  parallel_for(static_cast<std::int64_t>(source.usable.size()), 512, control,
               [&](std::int64_t begin, std::int64_t end) {
                 std::vector<float> query(kFeatureSize), distance(num_asked);
                 std::vector<int> found(num_asked);
                 for (std::int64_t i = begin; i < end; ++i) {
                   const std::int32_t pixel = source.usable[i];
                   features_of.fill(pixel, query.data());
                   flann::Matrix<int> indices(found.data(), 1, num_asked);
                   flann::Matrix<float> distances(distance.data(), 1, num_asked);
                   const flann::Matrix<float> queries(query.data(), 1, kFeatureSize);
                   index.knnSearch(queries, indices, distances, num_asked,
                                   flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED, kSlack));
                   std::size_t kept = 0;
                   for (std::size_t k = 0; k < num_asked && kept < kNumSimilar; ++k) {
                     const std::int32_t other = searched[found[k]];
                     if (is_apart(source, pixel, other)) similar[pixel][kept++] = other;
                   }
                 }
               });
  return similar;
}

SimilarPixels refine_similar_pixels(const SimilarPixels& coarse, const SourceLevel& coarse_source,
                                    const SourceLevel& fine_source) {
  SimilarPixels fine(fine_source.is_usable.size());
  for (auto& s : fine) s.fill(-1);
  const int coarse_margin = coarse_source.margin_px, fine_margin = fine_source.margin_px;
  const int last_x = coarse_source.width() - 1 - coarse_margin, last_y = coarse_source.height() - 1 - coarse_margin;
  for (std::int32_t pixel : fine_source.usable) {
    const int x = pixel % fine_source.width() - fine_margin, y = pixel / fine_source.width() - fine_margin;
    const int px = std::min(x / 2 + coarse_margin, last_x), py = std::min(y / 2 + coarse_margin, last_y);
    const auto& parents = coarse[py * coarse_source.width() + px];
    std::size_t kept = 0;
    for (std::int32_t parent : parents) {
      if (parent < 0) continue;
      const int fx = 2 * (parent % coarse_source.width() - coarse_margin) + x % 2 + fine_margin;
      const int fy = 2 * (parent / coarse_source.width() - coarse_margin) + y % 2 + fine_margin;
      if (fx >= fine_source.width() || fy >= fine_source.height()) continue;
      const std::int32_t candidate = fy * fine_source.width() + fx;
      if (fine_source.is_usable[candidate] != 0) {
        fine[pixel][kept++] = candidate;
      }
    }
  }
  return fine;
}

}  // namespace patinate::transfer
