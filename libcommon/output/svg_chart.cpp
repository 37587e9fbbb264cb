#include "libcommon/output/svg_chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kWidth = 620, kHeight = 300, kLeft = 64, kRight = 14, kTop = 34, kBottom = 46;
constexpr std::array<const char*, 7> kColors{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                             "#E69F00", "#56B4E9", "#7a7a7a"};
constexpr std::array<const char*, 4> kDashes{"", "7 3", "2 3", "9 3 2 3"};

constexpr std::size_t kMinTicks = 3;  ///< Least ticks of a logarithmic axis.

struct Axis {
  double low = 0.0, high = 1.0;
  bool is_log = false;
  double begin = 0.0, end = 1.0;  ///< In the picture.

  [[nodiscard]] double at(double v) const {
    const double s =
        is_log ? (std::log(v) - std::log(low)) / (std::log(high) - std::log(low)) : (v - low) / (high - low);
    return begin + s * (end - begin);
  }
};

std::string px(double v) { return number_text(std::round(10.0 * v) / 10.0); }

/// A round step that cuts the range into about five.
double step_of(double range) {
  const double raw = range / 5.0, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (double m : {1.0, 2.0, 5.0}) {
    if (raw <= m * power * 1.0001) return m * power;
  }
  return 10.0 * power;
}

std::vector<double> ticks_of(const Axis& axis) {
  std::vector<double> ticks;
  if (axis.is_log) {
    for (double p = std::floor(std::log10(axis.low)); p <= std::ceil(std::log10(axis.high)); p += 1.0) {
      for (double m : {1.0, 2.0, 5.0}) {
        const double v = rounded(m * std::pow(10.0, p), 6);
        if (v >= axis.low && v <= axis.high && (m == 1.0 || axis.high < 300.0 * axis.low)) ticks.push_back(v);
      }
    }
    if (ticks.size() >= kMinTicks) return ticks;
    ticks.clear();  // Less than a decade: even steps say more.
  }
  const double step = step_of(axis.high - axis.low);
  for (double k = std::ceil(axis.low / step - 1e-9); k * step <= axis.high + 1e-9 * step; k += 1.0)
    ticks.push_back(rounded(k * step, 9) + 0.0);
  return ticks;
}

void widen(std::optional<std::pair<double, double>>& range, double v) {
  if (!std::isfinite(v)) throw InvalidInput("chart: a value is not finite");
  range = range ? std::pair{std::min(range->first, v), std::max(range->second, v)} : std::pair{v, v};
}

Axis make_axis(std::optional<std::pair<double, double>> range, bool is_log, bool from_zero) {
  Axis axis{.low = range->first, .high = range->second, .is_log = is_log};
  if (is_log) {
    if (!(axis.low > 0.0)) throw InvalidInput("chart: a logarithmic axis needs values > 0");
    if (axis.low == axis.high) axis.low /= 2.0, axis.high *= 2.0;
    return axis;
  }
  if (from_zero) axis.low = std::min(axis.low, 0.0), axis.high = std::max(axis.high, 0.0);
  if (axis.low == axis.high) axis.high = axis.low + (axis.low == 0.0 ? 1.0 : std::abs(axis.low));
  return axis;
}

std::string text_at(double x, double y, const char* anchor, const std::string& text, const std::string& more = "") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
         html_escape(text) + "</text>\n";
}

std::string axes_text(const Axis& x, const Axis& y) {
  std::string out = "<g stroke=\"currentColor\" stroke-opacity=\"0.2\">\n", labels;
  const std::vector<double> xs = ticks_of(x), ys = ticks_of(y);
  for (double v : xs) {
    out += "<path d=\"M" + px(x.at(v)) + " " + px(y.begin) + "v4\"/>\n";
    labels += text_at(x.at(v), y.begin + 16, "middle", short_number_text(v));
  }
  for (double v : ys) {
    out += "<path d=\"M" + px(x.begin) + " " + px(y.at(v)) + "H" + px(x.end) + "\"/>\n";
    labels += text_at(x.begin - 6, y.at(v) + 4, "end", short_number_text(v));
  }
  return out + "</g>\n" + labels;
}

std::string line_text(const ChartSeries& s, const Axis& x, const Axis& y, std::size_t index) {
  const std::string color = kColors[index % kColors.size()];
  const char* dash = s.is_dashed ? kDashes[1] : kDashes[index / 2 % kDashes.size()];
  std::string out, path, dots;
  bool is_open = false;
  std::size_t num_points = 0;
  if (!s.band.empty()) {
    std::string upper, lower;
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      upper += (i == 0 ? "M" : "L") + px(x.at(s.x[i])) + " " + px(y.at(s.band[i].second));
      lower = "L" + px(x.at(s.x[i])) + " " + px(y.at(s.band[i].first)) + lower;
    }
    out += "<path d=\"" + upper + lower + "Z\" fill=\"" + color + "\" fill-opacity=\"0.18\" stroke=\"none\"/>\n";
  }
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (!s.y[i]) {
      is_open = false;
      continue;
    }
    const std::string at = px(x.at(s.x[i])) + " " + px(y.at(*s.y[i]));
    path += (is_open ? "L" : "M") + at;
    dots +=
        "<circle cx=\"" + px(x.at(s.x[i])) + "\" cy=\"" + px(y.at(*s.y[i])) + "\" r=\"2.6\" fill=\"" + color + "\"/>\n";
    is_open = true;
    ++num_points;
  }
  out += "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + color + "\" stroke-width=\"2\"" +
         (*dash != 0 ? " stroke-dasharray=\"" + std::string(dash) + "\"" : "") + "/>\n";
  return num_points <= 12 ? out + dots : out;
}

/// Drawn between the axes alone: a picture of its own shows nothing that lies outside.
std::string within(const std::string& lines, const Axis& x, const Axis& y) {
  const std::string width = px(x.end - x.begin), height = px(y.begin - y.end);
  return "<svg x=\"" + px(x.begin) + "\" y=\"" + px(y.end) + "\" width=\"" + width + "\" height=\"" + height +
         "\" viewBox=\"" + px(x.begin) + " " + px(y.end) + " " + width + " " + height + "\">\n" + lines + "</svg>\n";
}

}  // namespace

std::string svg_chart(const Chart& chart) {
  std::optional<std::pair<double, double>> xs, ys;
  for (const ChartSeries& s : chart.series) {
    if (s.y.size() != s.x.size() || (!s.band.empty() && s.band.size() != s.x.size()))
      throw InvalidInput("chart: a series has lists of different lengths");
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (!s.y[i]) continue;
      widen(xs, s.x[i]);
      widen(ys, *s.y[i]);
    }
    for (std::size_t i = 0; i < s.band.size(); ++i) {
      widen(xs, s.x[i]);
      if (chart.log_y && !(s.band[i].first > 0.0)) continue;
      widen(ys, s.band[i].first);
      widen(ys, s.band[i].second);
    }
  }
  std::string out =
      "<svg viewBox=\"0 0 620 300\" width=\"620\" height=\"300\" role=\"img\" font-size=\"12\" fill=\"currentColor\" "
      "font-family=\"system-ui, sans-serif\" aria-label=\"" +
      html_escape(chart.title) + "\">\n" +
      text_at(8, 18, "start", chart.title, " font-size=\"14\" font-weight=\"600\"");
  if (!xs || !ys) return out + text_at(kWidth / 2, kHeight / 2, "middle", "no values") + "</svg>\n";
  if (chart.y_range && !(chart.y_range->first < chart.y_range->second))
    throw InvalidInput("chart: the range of the y axis is empty");
  Axis x = make_axis(xs, chart.log_x, false),
       y = make_axis(chart.y_range ? chart.y_range : ys, chart.log_y, chart.from_zero && !chart.y_range);
  const bool has_legend = chart.series.size() > 1;
  x.begin = kLeft, x.end = kWidth - kRight;
  y.begin = kHeight - kBottom, y.end = kTop + (has_legend ? 16 : 0);
  out += axes_text(x, y);
  out += text_at((x.begin + x.end) / 2, kHeight - 8, "middle", chart.x_label);
  const std::string middle = px((y.begin + y.end) / 2);
  out += text_at(14, (y.begin + y.end) / 2, "middle", chart.y_label, " transform=\"rotate(-90 14 " + middle + ")\"");
  double legend_x = kLeft;
  std::string lines;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    lines += line_text(chart.series[i], x, y, i);
    if (!has_legend) continue;
    out += "<rect x=\"" + px(legend_x) + "\" y=\"30\" width=\"12\" height=\"4\" fill=\"" +
           std::string(kColors[i % kColors.size()]) + "\"/>\n";
    out += text_at(legend_x + 17, 36, "start", chart.series[i].name);
    legend_x += 32.0 + 6.6 * static_cast<double>(chart.series[i].name.size());
  }
  return out + (chart.y_range ? within(lines, x, y) : lines) + "</svg>\n";
}

std::string svg_document(std::string chart) {
  const std::string start = "<svg";
  return chart.insert(start.size(), " xmlns=\"http://www.w3.org/2000/svg\"");
}

}  // namespace patinate
