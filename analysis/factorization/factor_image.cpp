#include "analysis/factorization/factor_image.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace patinate::analysis {

namespace {

constexpr std::size_t kOfModel = 5;  ///< Channels of one model.
constexpr std::size_t kMaxCoefficients = 1000;
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

Json models_json(std::span<const TemporalModel> models) {
  Json list = Json::array();
  constexpr std::array<const char*, 3> kNames{"R", "G", "B"};
  for (std::size_t m = 0; m < models.size(); ++m) {
    Json names = Json::array();
    for (std::size_t c = 0; c < 3; ++c) {
      if (models.size() == 1 || c == m) names.push_back(kNames[c]);
    }
    list.push_back({{"channels", names},
                    {"low", models[m].curve.low},
                    {"high", models[m].curve.high},
                    {"coefficients", models[m].curve.coefficients},
                    {"noise", models[m].noise},
                    {"correlation", models[m].correlation}});
  }
  return list;
}

std::vector<TemporalModel> read_models(const JsonReader& json) {
  std::vector<TemporalModel> models;
  for (JsonReader& entry : json.elements(3)) {
    TemporalModel model;
    const std::size_t channels = entry.member("channels").elements(3).size();
    model.curve.low = entry.member("low").number();
    model.curve.high = entry.member("high").number();
    if (!(model.curve.high > model.curve.low)) entry.member("high").fail("more than low");
    const JsonReader coefficients = entry.member("coefficients");
    for (const JsonReader& list : coefficients.elements(channels)) {
      const std::size_t size = list.elements(kMaxCoefficients).size();
      if (size < 4 || (!model.curve.coefficients.empty() && size != model.curve.coefficients.front().size()))
        list.fail("at least 4 coefficients, as many for every channel");
      model.curve.coefficients.push_back(list.numbers(size));
    }
    if (model.curve.coefficients.size() != channels) coefficients.fail("a list for every channel");
    model.noise = entry.member("noise").numbers(channels, above(0));
    model.correlation = entry.member("correlation").number(between(0, 0.99));
    entry.finish();
    models.push_back(std::move(model));
  }
  if (models.size() != 1 && models.size() != 3) json.fail("one curve for all channels, or three");
  if (models.front().curve.num_channels() != (models.size() == 1 ? 3 : 1)) json.fail("three channels in all");
  return models;
}

}  // namespace patinate::analysis
