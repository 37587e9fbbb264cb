#include <utility>

#include "patinate/analysis/factorization.h"
#include "python/analysis/py_analysis.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

constexpr int kCurveSamples = 257;

/// One value of every place, laid out over the pixels of the mask; 0 outside.
template <class F>
py::array map_of(const ImageU8& mask, const std::vector<analysis::PlaceFactors>& factors, int channels, F&& value) {
  ImageF out(mask.width(), mask.height(), channels);
  std::size_t place = 0;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] == 0) continue;
    for (int c = 0; c < channels; ++c) out.data()[i * channels + c] = static_cast<float>(value(factors[place], c));
    ++place;
  }
  return array_of(std::move(out));
}

py::dict factors_dict(const analysis::TemporalModel& model, const std::vector<analysis::PlaceFactors>& factors,
                      const ImageU8& mask) {
  const int channels = model.curve.num_channels();
  using Place = analysis::PlaceFactors;
  py::dict out;
  std::vector<double> clock;
  for (int i = 0; i < kCurveSamples; ++i)
    clock.push_back(model.curve.low + (model.curve.high - model.curve.low) * i / (kCurveSamples - 1));
  out["clock"] = array_of(clock);
  py::list curve;
  for (int c = 0; c < channels; ++c) curve.append(array_of(model.curve.samples(c, kCurveSamples)));
  out["curve"] = py::module_::import("numpy").attr("stack")(curve, py::arg("axis") = -1);
  out["noise"] = array_of(model.noise);
  out["rate"] = map_of(mask, factors, 1, [](const Place& p, int) { return p.rate; });
  out["offset"] = map_of(mask, factors, 1, [](const Place& p, int) { return p.offset; });
  out["rate_stddev"] = map_of(mask, factors, 1, [](const Place& p, int) { return p.rate_stddev; });
  out["gain"] = map_of(mask, factors, channels, [](const Place& p, int c) { return p.gain[c]; });
  out["base"] = map_of(mask, factors, channels, [](const Place& p, int c) { return p.base[c]; });
  out["residual"] = map_of(mask, factors, 1, [](const Place& p, int) { return p.residual; });
  ImageU8 status(mask.width(), mask.height());
  std::size_t place = 0;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] != 0) status.data()[i] = static_cast<std::uint8_t>(factors[place++].status);
  }
  out["status"] = array_of(std::move(status));
  return out;
}

}  // namespace

void bind_factorize(py::module_& module) {
  define(module,
         FunctionText("factorize",
                      "A history as one curve of aging and a few maps: color(t) = gain curve(rate t - offset) + base "
                      "at every pixel.")
             .takes("history", "History", "Of at least 4 frames")
             .options<analysis::FactorizationOptions>()
             .runs()
             .returns("list[dict[str, npt.NDArray[Any]]]",
                      "One, or one for each channel with clock='channels': clock (257 times), curve (257 x channels), "
                      "noise (channels); maps "
                      "H x W: rate, rate_stddev, offset (units of time), residual; gain and base (H x W x channels); "
                      "status (0 unseen, 1 "
                      "unchanged, 2 open, 3 fitted)")
             .raises("InvalidInput with fewer frames, or when no place changes; IoError"),
         [](const PyHistory& history, const py::kwargs& kwargs) {
           Keywords keywords("factorize", kwargs);
           analysis::FactorizationOptions options;
           keywords.read(options);
           const RunArguments run = keywords.run();
           keywords.finish();
           const auto [mask, made] = result_of(run, [=](const RunControl& control) {
             return std::pair(history.value->read_mask(), analysis::factorize(*history.value, options, control));
           });
           py::list out;
           for (std::size_t i = 0; i < made.models.size(); ++i)
             out.append(factors_dict(made.models[i], made.factors[i], mask));
           return out;
         });
}

}  // namespace patinate::python
