#include "capture/stability/fill.h"

#include <algorithm>
#include <map>

#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr auto kValid = static_cast<std::uint8_t>(Validity::Valid);
constexpr auto kSaturated = static_cast<std::uint8_t>(Validity::Saturated);

/// The nearest valid frames of pixels that must be filled.
struct Ends {
  std::vector<std::int64_t> pixels;
  std::vector<int> before, after;
};

bool is_white(const FillPlan& plan, std::int64_t pixel, int index) { return index >= plan.white_from.data()[pixel]; }

}  // namespace

void describe(OptionVisitor& v, FillOptions& o) {
  v.visit({"longest_gap",
           "Longest gap, as a share of the recorded time, over which masked pixels are filled from neighboring frames",
           "", between(0, 1)},
          o.longest_gap);
}

FillPlan plan_fill(const std::vector<double>& times, const std::function<ImageU8(int)>& read_validity,
                   const FillOptions& options, const RunControl& control) {
  check_ranges(options);
  if (times.empty()) throw InvalidInput("fill: there are no frames");
  const int n = static_cast<int>(times.size());
  const double longest = options.longest_gap * (times.back() - times.front());
  FillPlan plan;
  plan.needs_fill.assign(times.size(), 0);
  Image<std::int32_t> last_valid;
  double num_invalid = 0.0;
  for (int i = 0; i < n; ++i) {
    control.throw_if_stopped();
    const ImageU8 validity = read_validity(i);
    if (i == 0) {
      plan.inside = ImageU8(validity.width(), validity.height(), 1, 255);
      plan.white_from = Image<std::int32_t>(validity.width(), validity.height(), 1, n);
      last_valid = Image<std::int32_t>(validity.width(), validity.height(), 1, -1);
    }
    if (!validity.same_size(plan.inside)) throw InvalidInput("fill: the frames differ in size");
    for (std::int64_t p = 0; p < validity.num_pixels(); ++p) {
      const std::uint8_t code = validity.data()[p];
      std::int32_t& last = last_valid.data()[p];
      std::int32_t& white = plan.white_from.data()[p];
      if (code == kSaturated) {
        white = std::min(white, i);
      } else {
        white = n;
      }
      if (code != kValid) {
        num_invalid += 1.0;
        continue;
      }
      const std::int32_t before = last;
      last = i;
      if (before == i - 1) continue;
      const double gap = before < 0 ? 0.0 : times[i] - times[before];
      if (before < 0 || (i - before > 2 && gap > longest)) {
        plan.inside.data()[p] = 0;
        continue;
      }
      for (std::int32_t k = before + 1; k < i; ++k) plan.needs_fill[k] = 1;
    }
    control.report(static_cast<double>(i + 1) / n);
  }
  for (std::int64_t p = 0; p < plan.inside.num_pixels(); ++p) {
    const std::int32_t last = last_valid.data()[p];
    const bool grew_white = last >= 0 && plan.white_from.data()[p] == last + 1;
    if (last != n - 1 && !grew_white) plan.inside.data()[p] = 0;
    if (!grew_white) plan.white_from.data()[p] = n;
  }
  plan.invalid_share = num_invalid / (static_cast<double>(plan.inside.num_pixels()) * n);
  return plan;
}

ImageF fill_frame(int index, const std::vector<double>& times, const FillPlan& plan,
                  const std::function<ImageU8(int)>& read_validity, const std::function<ImageF(int)>& read_frame) {
  ImageF frame = read_frame(index);
  const ImageU8 validity = read_validity(index);
  Ends ends;
  for (std::int64_t p = 0; p < validity.num_pixels(); ++p) {
    if (validity.data()[p] != kValid && plan.inside.data()[p] != 0 && !is_white(plan, p, index))
      ends.pixels.push_back(p);
  }
  const int n = static_cast<int>(times.size());
  const auto find = [&](int step) {
    std::vector<int> found(ends.pixels.size(), -1);
    std::size_t num_left = found.size();
    for (int i = index + step; i >= 0 && i < n && num_left > 0; i += step) {
      const ImageU8 other = read_validity(i);
      for (std::size_t k = 0; k < found.size(); ++k) {
        if (found[k] >= 0 || other.data()[ends.pixels[k]] != kValid) continue;
        found[k] = i;
        --num_left;
      }
    }
    return found;
  };
  ends.before = find(-1);
  ends.after = find(1);
  std::map<int, std::vector<std::size_t>>
      users;  // Frame -> entries that need it: each frame is read once, one at a time.
  for (std::size_t k = 0; k < ends.pixels.size(); ++k) {
    if (ends.before[k] < 0 || ends.after[k] < 0) continue;
    users[ends.before[k]].push_back(k);
    users[ends.after[k]].push_back(k);
    for (int c = 0; c < frame.channels(); ++c) frame.data()[ends.pixels[k] * frame.channels() + c] = 0.0f;
  }
  for (const auto& [i, entries] : users) {
    const ImageF other = read_frame(i);
    for (std::size_t k : entries) {
      const double t0 = times[ends.before[k]], t1 = times[ends.after[k]];
      const double fraction = (times[index] - t0) / (t1 - t0);
      const float weight = static_cast<float>(i == ends.before[k] ? 1.0 - fraction : fraction);
      for (int c = 0; c < frame.channels(); ++c) {
        const std::int64_t at = ends.pixels[k] * frame.channels() + c;
        frame.data()[at] += weight * other.data()[at];
      }
    }
  }
  return frame;
}

ImageU8 frame_mask(int index, const ImageU8& validity, const FillPlan& plan) {
  ImageU8 mask(validity.width(), validity.height());
  for (std::int64_t p = 0; p < validity.num_pixels(); ++p) {
    mask.data()[p] = validity.data()[p] == kValid || is_white(plan, p, index) ? 255 : 0;
  }
  return mask;
}

}  // namespace patinate::capture
