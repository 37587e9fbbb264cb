#include "analysis/factorization/factor_image.h"

#include <algorithm>

namespace patinate::analysis {

namespace {

constexpr std::size_t kOfModel = 5;  ///< Channels of one model.
constexpr double kLargestHalf = 65504.0;

/// Model that a color channel belongs to, and the number of the channel in it.
struct ModelChannel {
  std::size_t model = 0;
  int channel = 0;
};
ModelChannel model_channel(std::size_t color, std::size_t num_models) {
  return num_models == 1 ? ModelChannel{0, static_cast<int>(color)} : ModelChannel{color, 0};
}

}  // namespace

std::vector<std::string> factor_channel_names(std::size_t num_models) {
  std::vector<std::string> names;
  for (std::size_t m = 0; m < num_models; ++m) {
    for (const char* name : {"status", "rate", "offset", "rate_stddev", "residual"})
      names.push_back(name + std::string(".") + std::to_string(m));
  }
  for (const char* name : {"gain.R", "gain.G", "gain.B", "base.R", "base.G", "base.B"}) names.emplace_back(name);
  return names;
}

ImageF factor_image(int width, int height, const std::vector<std::vector<PlaceFactors>>& factors) {
  const std::size_t num_models = factors.size(), channels = kOfModel * num_models + 6;
  ImageF image(width, height, static_cast<int>(channels));
  for (std::size_t i = 0; i < factors.front().size(); ++i) {
    float* out = image.data() + i * channels;
    for (std::size_t m = 0; m < num_models; ++m) {
      const PlaceFactors& f = factors[m][i];
      float* of = out + kOfModel * m;
      of[0] = static_cast<float>(f.status), of[1] = static_cast<float>(f.rate), of[2] = static_cast<float>(f.offset);
      of[3] = static_cast<float>(f.rate_stddev), of[4] = static_cast<float>(f.residual);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const ModelChannel at = model_channel(c, num_models);
      out[kOfModel * num_models + c] = static_cast<float>(factors[at.model][i].gain[at.channel]);
      out[kOfModel * num_models + 3 + c] = static_cast<float>(factors[at.model][i].base[at.channel]);
    }
  }
  return image;
}

PlaceFactors factors_at(const ImageF& image, std::int64_t pixel, std::size_t model, std::size_t num_models) {
  const float* in = image.data() + pixel * image.channels();
  const float* of = in + kOfModel * model;
  PlaceFactors f{
      .status = static_cast<PlaceStatus>(static_cast<int>(std::clamp(of[0], 0.0f, kNumPlaceStatuses - 1.0f))),
      .rate = static_cast<double>(of[1]),
      .offset = static_cast<double>(of[2]),
      .rate_stddev = static_cast<double>(of[3]),
      .residual = static_cast<double>(of[4])};
  for (std::size_t c = 0; c < 3; ++c) {
    const ModelChannel at = model_channel(c, num_models);
    if (at.model != model) continue;
    f.gain[at.channel] = static_cast<double>(in[kOfModel * num_models + c]);
    f.base[at.channel] = static_cast<double>(in[kOfModel * num_models + 3 + c]);
  }
  return f;
}

std::array<float, 3> factored_color(std::span<const TemporalModel> models, const ImageF& image, std::int64_t pixel,
                                    double time, double lowest) {
  std::array<float, 3> color{};
  for (std::size_t c = 0; c < 3; ++c) {
    const ModelChannel at = model_channel(c, models.size());
    const double v =
        factored_value(models[at.model].curve, factors_at(image, pixel, at.model, models.size()), at.channel, time);
    color[c] = static_cast<float>(std::clamp(v, lowest, kLargestHalf));
  }
  return color;
}

bool is_covered(std::span<const TemporalModel> models, const ImageF& image, std::int64_t pixel, double time) {
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (!is_covered(models[m].curve, factors_at(image, pixel, m, models.size()), time)) return false;
  }
  return true;
}

}  // namespace patinate::analysis
