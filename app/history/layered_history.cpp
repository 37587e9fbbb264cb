#include "app/history/layered_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "libcommon/controls/control_expression.h"
#include "libcommon/core/parallel.h"
#include "libcommon/history/footprint.h"
#include "libcommon/history/material_range.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/history/history_sampling.h"
#include "patinate/history/write_history.h"
#include "patinate/transfer/transfer_io.h"

namespace patinate::app {

namespace {

constexpr float kOpen = 0.5f;  // Share from which on a place is open.
constexpr std::array<std::string_view, 5> kLook{"height", "metalness", "roughness", "lightness", "change"};

/// A map at a time, or what stands where nobody knows.
ImageF map_at(const History& history, MaterialMap map, double time) {
  const std::vector<MaterialMap> known = material_maps(history.facts());
  const int width = history.facts().width, height = history.facts().height;
  if (std::find(known.begin(), known.end(), map) != known.end())
    return sample_material_map(history, map, time, Between::Blend);
  if (map == MaterialMap::Normal) {
    ImageF flat(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) flat.at(x, y, 2) = 1.0f;
    }
    return flat;
  }
  return {width, height, 1,
          map == MaterialMap::Roughness  ? kUnknownRoughness
          : map == MaterialMap::Specular ? kUnknownSpecular
                                         : 0.0f};
}

/// Index of a pixel in an image of n that is mirrored at its ends.
int mirrored(int i, int n) {
  const int period = 2 * n, at = ((i % period) + period) % period;
  return at < n ? at : period - 1 - at;
}

/// `source` laid over width x height pixels, of which one covers `ratio` of its own.
ImageF laid_over(const ImageF& source, int width, int height, double ratio) {
  if (ratio == 1.0 && source.width() == width && source.height() == height) return source;
  const int channels = source.channels();
  ImageF out(width, height, channels);
  for (int y = 0; y < height; ++y) {
    const double v = (y + 0.5) * ratio - 0.5;
    const int y0 = static_cast<int>(std::floor(v));
    const auto fy = static_cast<float>(v - y0);
    for (int x = 0; x < width; ++x) {
      const double u = (x + 0.5) * ratio - 0.5;
      const int x0 = static_cast<int>(std::floor(u));
      const auto fx = static_cast<float>(u - x0);
      const auto tap = [&](int dx, int dy, int c) {
        return source.at(mirrored(x0 + dx, source.width()), mirrored(y0 + dy, source.height()), c);
      };
      for (int c = 0; c < channels; ++c) {
        // At whole pixels exactly that one: nothing is added to it.
        const float top = fx == 0.0f ? tap(0, 0, c) : (1.0f - fx) * tap(0, 0, c) + fx * tap(1, 0, c);
        if (fy == 0.0f) {
          out.at(x, y, c) = top;
          continue;
        }
        const float bottom = fx == 0.0f ? tap(0, 1, c) : (1.0f - fx) * tap(0, 1, c) + fx * tap(1, 1, c);
        out.at(x, y, c) = (1.0f - fy) * top + fy * bottom;
      }
    }
  }
  return out;
}

class LayeredHistory final : public History {
 public:
  /// @throws ParseError in words of its own: those of ControlExpression are about files, too.
  static const std::string& checked(const std::string& where, const std::vector<std::string>& names) {
    (void)parse_expression(where, {.subject = "where", .name = "name", .names = names, .has_files = false});
    return where;
  }

  LayeredHistory(LayerTask task, const RunControl& control)
      : below_(std::move(task.below)),
        above_(std::move(task.above)),
        expression_(checked(task.where, names_of(*below_)), names_of(*below_)) {
    const HistoryFacts &b = below_->facts(), &a = above_->facts();
    if (b.texel_size_mm && a.texel_size_mm) ratio_ = *b.texel_size_mm / *a.texel_size_mm;
    if (std::abs(ratio_ - 1.0) < 1e-9) ratio_ = 1.0;
    if (ratio_ > kMinFootprint_px) above_ = std::make_shared<const FootprintHistory>(above_, ratio_);
    const double span_below = b.frames.back().time - b.frames.front().time;
    const double span_above = a.frames.back().time - a.frames.front().time;
    rate_ = task.clock == transfer::LibraryClock::Span && span_above > 0.0 && span_below > 0.0
                ? span_above / span_below
                : seconds_per(b.time_unit) / seconds_per(a.time_unit);
    find_onsets(task.where, control);
    state_facts();
    const ImageU8 usable = a.has_mask ? above_->read_mask() : ImageU8();
    if (!usable.empty()) {
      ImageF shares(usable.width(), usable.height());
      std::transform(usable.values().begin(), usable.values().end(), shares.values().begin(),
                     [](std::uint8_t v) { return v != 0 ? 1.0f : 0.0f; });
      usable_ = laid_over(shares, b.width, b.height, ratio_);
    }
  }

  [[nodiscard]] const HistoryFacts& facts() const override { return facts_; }
  [[nodiscard]] const std::string& label() const override { return facts_.name; }

 private:
  static std::vector<std::string> names_of(const History& history) {
    std::vector<std::string> names;
    for (const ControlFacts& c : history.facts().controls) names.push_back(c.name);
    names.insert(names.end(), kLook.begin(), kLook.end());
    return names;
  }

  /// Value of a name in the expression at a time.
  [[nodiscard]] ImageF named(const std::string& name, double time) const {
    for (const ControlFacts& c : below_->facts().controls) {
      if (c.name == name) return below_->read_control(name);
    }
    if (name == "height") return map_at(*below_, MaterialMap::Height, time);
    if (name == "metalness") return map_at(*below_, MaterialMap::Metalness, time);
    if (name == "roughness") return map_at(*below_, MaterialMap::Roughness, time);
    const ImageF now = below_->sample(time), first = name == "change" ? below_->read_frame(0) : ImageF();
    const auto lab_of = [](const ImageF& image, std::int64_t p) {
      const float* c = image.data() + 3 * p;
      return lab_from_linear(c[0], c[1], c[2]);
    };
    ImageF out(now.width(), now.height());
    for (std::int64_t p = 0; p < out.num_pixels(); ++p) {
      const std::array<double, 3> lab = lab_of(now, p);
      const std::array<double, 3> was = first.empty() ? std::array<double, 3>{} : lab_of(first, p);
      const double value = first.empty() ? lab[0] : std::hypot(lab[0] - was[0], lab[1] - was[1], lab[2] - was[2]);
      out.data()[p] = static_cast<float>(value / 100.0);
    }
    return out;
  }

  /// Share of `above` that shows, H x W.
  [[nodiscard]] ImageF shares(double time) const {
    const ImageU8 all(below_->facts().width, below_->facts().height, 1, std::uint8_t{255});
    ImageF out = expression_
                     .evaluate(all,
                               [&](const ControlName& asked) {
                                 return ControlMap{.values = named(asked.text, time), .unit = "relative"};
                               })
                     .values;
    if (usable_.empty()) return out;
    std::transform(out.values().begin(), out.values().end(), usable_.values().begin(), out.values().begin(),
                   [](float share, float usable) { return usable > 0.999f ? share : 0.0f; });
    return out;
  }

  void find_onsets(const std::string& where, const RunControl& control) {
    const HistoryFacts& b = below_->facts();
    onset_ = ImageF(b.width, b.height, 1, std::numeric_limits<float>::infinity());
    first_onset_ = std::numeric_limits<double>::infinity();
    ImageF before;
    for (std::size_t i = 0; i < b.frames.size(); ++i) {
      control.throw_if_stopped();
      const double time = b.frames[i].time;
      ImageF now = shares(time);
      for (std::int64_t p = 0; p < onset_.num_pixels(); ++p) {
        float& onset = onset_.data()[p];
        if (std::isfinite(onset) || now.data()[p] < kOpen) continue;
        double at = time;
        if (i > 0) {  // It passed the half between the frames.
          const double was = before.data()[p], is = now.data()[p];
          at -= (time - b.frames[i - 1].time) * (is - double{kOpen}) / std::max(1e-9, is - was);
        }
        onset = static_cast<float>(at);
        first_onset_ = std::min(first_onset_, at);
      }
      before = std::move(now);
    }
    if (!std::isfinite(first_onset_))
      throw InvalidInput("where: `" + where +
                         "` is above a half nowhere, at no time of the lower history: nothing of the upper one would "
                         "show");
  }

  void state_facts() {
    const HistoryFacts &b = below_->facts(), &a = above_->facts();
    facts_ = b;
    facts_.name = b.name + " + " + a.name;
    if (a.origin != b.origin) facts_.origin = "synthetic";  // Histories of different origin are synthetic as a whole.
    facts_.parts.clear();
    std::erase_if(facts_.maps, [](const std::string& name) { return is_material_map(name); });
    std::vector<std::string> extras;
    for (const History* history : {below_.get(), above_.get()}) {
      for (const MaterialMap map : material_maps(history->facts())) {
        if (map == MaterialMap::Stddev || map == MaterialMap::Tint) continue;
        const bool is_gloss = map == MaterialMap::Roughness || map == MaterialMap::Specular;
        extras.emplace_back(is_gloss ? "specular" : kMaterialMapNames[static_cast<std::size_t>(map)]);
      }
    }
    std::vector<double> times = below_->times();
    for (const double t : above_->times()) times.push_back(first_onset_ + (t - a.frames.front().time) / rate_);
    std::sort(times.begin(), times.end());
    const double step = 1e-6 * std::max(1e-9, times.back() - times.front());
    times.erase(std::unique(times.begin(), times.end(), [&](double s, double t) { return t - s < step; }), times.end());
    facts_.frames.clear();
    for (const double time : times) {
      FrameFacts& frame = facts_.frames.emplace_back();
      frame.time = time;
      for (const std::string_view name : kFrameExtraNames) {
        if (std::find(extras.begin(), extras.end(), name) != extras.end()) frame.extras.emplace_back(name);
      }
    }
  }

  using Stack = std::vector<ImageF>;
  /// Every frame of `above` laid over `below`, made when first asked for. @param make  Of a frame.
  [[nodiscard]] const Stack& stack(const std::string& name, const std::function<ImageF(int frame)>& make) const {
    const std::lock_guard lock(mutex_);
    Stack& laid = stacks_[name];
    if (laid.empty()) {
      const HistoryFacts& b = below_->facts();
      for (int j = 0; j < above_->num_frames(); ++j) laid.push_back(laid_over(make(j), b.width, b.height, ratio_));
    }
    return laid;
  }

  /// `below`, with `above` at every place's own time.
  /// @param is_added  What lies above is added, not in place of what lies below.
  [[nodiscard]] ImageF blended(ImageF below, const Stack& above, double time, bool is_added) const {
    const ImageF share = shares(time);
    const std::vector<double> times = above_->times();
    const int channels = below.channels();
    parallel_for(below.num_pixels(), 1 << 14, {}, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t p = begin; p < end; ++p) {
        const float w = share.data()[p];
        if (w <= 0.0f) continue;
        const double age = std::max(0.0, time - static_cast<double>(onset_.data()[p])) * rate_ + times.front();
        const auto next = std::upper_bound(times.begin(), times.end(), age);
        const std::size_t j = next == times.begin() ? 0 : static_cast<std::size_t>(next - times.begin()) - 1;
        const std::size_t k = std::min(j + 1, times.size() - 1);
        const auto f = static_cast<float>(k == j ? 0.0 : (age - times[j]) / (times[k] - times[j]));
        for (int c = 0; c < channels; ++c) {
          const float top = (1.0f - f) * above[j].data()[p * channels + c] + f * above[k].data()[p * channels + c];
          float& value = below.data()[p * channels + c];
          value = is_added ? value + w * top : (1.0f - w) * value + w * top;
        }
      }
    });
    return below;
  }

  [[nodiscard]] ImageF blended_map(MaterialMap map, double time) const {
    const Stack& above = stack(std::string(kMaterialMapNames[static_cast<std::size_t>(map)]),
                               [&](int j) { return map_at(*above_, map, above_->facts().frames[j].time); });
    return blended(map_at(*below_, map, time), above, time, map == MaterialMap::Height);
  }

  [[nodiscard]] ImageF load_frame(std::size_t frame) const override {
    const double time = facts_.frames[frame].time;
    return blended(below_->sample(time), stack("color", [&](int j) { return above_->read_frame(j); }), time, false);
  }
  [[nodiscard]] ImageF load_frame_extra(std::size_t frame, std::size_t extra) const override {
    const double time = facts_.frames[frame].time;
    const std::string& name = facts_.frames[frame].extras[extra];
    if (name == "height") return blended_map(MaterialMap::Height, time);
    if (name == "metalness") return blended_map(MaterialMap::Metalness, time);
    if (name == "specular") {
      const ImageF strength = blended_map(MaterialMap::Specular, time),
                   roughness = blended_map(MaterialMap::Roughness, time);
      ImageF both(strength.width(), strength.height(), 2);
      for (std::int64_t p = 0; p < both.num_pixels(); ++p) {
        both.data()[2 * p] = strength.data()[p];
        both.data()[2 * p + 1] = roughness.data()[p];
      }
      return both;
    }
    ImageF normals = blended_map(MaterialMap::Normal, time);
    for (std::int64_t p = 0; p < normals.num_pixels(); ++p) {
      float* n = normals.data() + 3 * p;
      const float length = std::hypot(n[0], n[1], n[2]);
      for (int c = 0; c < 3; ++c) n[c] = length > 0.0f ? n[c] / length : (c == 2 ? 1.0f : 0.0f);
    }
    return normals;
  }
  [[nodiscard]] ImageF load_control(std::size_t control) const override {
    return below_->read_control(facts_.controls[control].name);
  }
  [[nodiscard]] ImageF load_control_deviation(std::size_t control) const override {
    return *below_->read_control_deviation(facts_.controls[control].name);
  }
  [[nodiscard]] ImageU8 load_mask() const override { return below_->read_mask(); }
  [[nodiscard]] ImageF load_map(std::size_t map) const override { return below_->read_map(facts_.maps[map]); }
  [[nodiscard]] ImageU8 load_frame_mask(std::size_t) const override { return below_->read_mask(); }

  std::shared_ptr<const History> below_, above_;
  ControlExpression expression_;
  double ratio_ = 1.0;  ///< Pixels of `above` along one of `below`.
  double rate_ = 1.0;   ///< Time of `above` in one of `below`.
  ImageF onset_;        ///< H x W: when a place opens.
  double first_onset_ = 0.0;
  ImageF usable_;  ///< H x W: where `above` shows its surface; empty: everywhere.
  HistoryFacts facts_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, Stack> stacks_;
};

}  // namespace

std::shared_ptr<const History> layered_history(LayerTask task, const RunControl& control) {
  return std::make_shared<const LayeredHistory>(std::move(task), control);
}

JobPlan plan_layers(const std::filesystem::path& below, const std::filesystem::path& above, const std::string& where,
                    transfer::LibraryClock clock, const std::filesystem::path& output) {
  const auto lower = std::make_shared<const HistoryReader>(below), upper = std::make_shared<const HistoryReader>(above);
  JobInputs inputs("layers", 1);
  inputs.add_content("history", "the lower history", transfer::history_content_key(*lower));
  inputs.add_content("history", "the upper history", transfer::history_content_key(*upper));
  inputs.add_value("--where", where);
  inputs.add_value("--clock", std::string(transfer::kLibraryClockNames[static_cast<std::size_t>(clock)]));
  JobPlan plan = inputs.plan(output, kHistoryManifestFile);
  plan.join = [=, key = plan.key](const std::filesystem::path& folder, const RunControl& control) {
    const auto layered =
        layered_history({.below = lower, .above = upper, .where = where, .clock = clock}, control.part(0.0, 0.1));
    write_history_files(folder, *layered, key, control.part(0.1, 1.0));
  };
  return plan;
}

}  // namespace patinate::app
