#include "tools/evaluate_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stevedore {
namespace {

constexpr double width = 560, height = 300, left = 62, right = 12, top = 44, bottom = 44;  // pixels
constexpr std::size_t most_points = 3000;  // of a series: more are not told apart, and make a page slow

/// A step of 1, 2 or 5 times a power of ten, for four to ten marks.
double step_of(double range) {
  const double power = std::pow(10, std::floor(std::log10(range / 4)));
  const double rest = range / 4 / power;
  return power * (rest < 5 ? (rest < 2 ? 1 : 2) : 5);
}

std::vector<double> marks_between(double least, double largest, double step) {
  std::vector<double> marks;
  for (auto k = static_cast<int>(std::ceil(least / step)); k * step <= largest; ++k)
    marks.push_back(k * step);
  return marks;
}

struct Axis {
  double least, largest;

  /// Values that are the same but for rounding have no scale of their own.
  void widen() {
    if (largest - least > 1e-9) return;
    least -= 0.5;
    largest += 0.5;
  }
  [[nodiscard]] bool holds(double value) const { return value >= least && value <= largest; }
  [[nodiscard]] double share(double value) const { return (value - least) / (largest - least); }
};

Axis axis_of(std::vector<double> values, double left_out) {
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  const auto cut = static_cast<std::size_t>(left_out / 2 * count);
  Axis axis{values[cut], values[values.size() - 1 - cut]};
  axis.widen();
  const double margin = 0.04 * (axis.largest - axis.least);
  return {axis.least - margin, axis.largest + margin};
}

class Canvas {
 public:
  Canvas(Axis x, Axis y, bool is_log_y) : x_(x), y_(y), is_log_y_(is_log_y) {}

  [[nodiscard]] double u(double x) const { return left + x_.share(x) * (width - left - right); }
  [[nodiscard]] double v(double y) const { return height - bottom - y_.share(y) * (height - top - bottom); }
  [[nodiscard]] bool holds(const PlotPoint& point) const { return x_.holds(point.x) && y_.holds(point.y); }

  [[nodiscard]] std::string grid() const {
    std::string svg;
    for (const double x : marks_between(x_.least, x_.largest, step_of(x_.largest - x_.least))) {
      svg += fmt::format(
          R"(<line class="g" x1="{0:.1f}" x2="{0:.1f}" y1="{1}" y2="{2}"/><text x="{0:.1f}" y="{3}" text-anchor="middle">{4:g}</text>)",
          u(x), top, height - bottom, height - bottom + 15, x);
    }
    for (const double y :
         marks_between(y_.least, y_.largest, is_log_y_ ? 1 : step_of(y_.largest - y_.least))) {
      svg += fmt::format(
          R"(<line class="{5}" x1="{1}" x2="{2}" y1="{0:.1f}" y2="{0:.1f}"/><text x="{3}" y="{4:.1f}" text-anchor="end">{6:g}</text>)",
          v(y), left, width - right, left - 5, v(y) + 4, y == 0 && !is_log_y_ ? "z" : "g",
          is_log_y_ ? std::pow(10, y) : y);
    }
    return svg;
  }

  [[nodiscard]] std::string line(const PlotSeries& series) const {
    std::string path;
    const PlotPoint* before = nullptr;
    for (const PlotPoint& point : series.points) {
      if (!holds(point)) {
        before = nullptr;
        continue;
      }
      const bool goes_on = before && point.x - before->x <= series.gap;
      path += fmt::format("{}{:.1f} {:.1f}", goes_on ? 'L' : 'M', u(point.x), v(point.y));
      before = &point;
    }
    return fmt::format(R"(<path d="{}" fill="none" stroke="{}" stroke-width="1.6"/>)", path, series.colour);
  }

  [[nodiscard]] std::string dots(const PlotSeries& series) const {
    std::string path;
    const bool are_few = series.points.size() < 30;
    const std::size_t stride = 1 + series.points.size() / most_points;
    for (std::size_t i = 0; i < series.points.size(); i += stride) {
      const PlotPoint& point = series.points[i];
      if (holds(point)) path += fmt::format("M{:.1f} {:.1f}h0", u(point.x), v(point.y));
    }
    return fmt::format(
        R"(<path d="{}" fill="none" stroke="{}" stroke-width="{}" stroke-linecap="round" stroke-opacity="{}"/>)",
        path, series.colour, are_few ? 8 : 3.4, are_few ? 1 : 0.55);
  }

 private:
  Axis x_, y_;
  bool is_log_y_;
};

}  // namespace

std::string escaped(const std::string& text) {
  std::string html;
  for (const char c : text) {
    if (c == '&') html += "&amp;";
    if (c == '<') html += "&lt;";
    if (c == '>') html += "&gt;";
    if (c == '"') html += "&quot;";
    if (c != '&' && c != '<' && c != '>' && c != '"') html += c;
  }
  return html;
}

std::string svg_of(const Plot& plot) {
  std::vector<double> xs, ys;
  for (const PlotSeries& series : plot.series) {
    for (const PlotPoint& point : series.points) {
      xs.push_back(point.x);
      ys.push_back(point.y);
    }
  }
  if (xs.empty()) return {};
  const Axis x = axis_of(std::move(xs), 0);
  Axis y{plot.least_y, plot.largest_y};
  if (y.least == y.largest) y = axis_of(std::move(ys), 0.01);
  const Canvas canvas(x, y, plot.is_log_y);

  std::string body, legend;
  std::size_t beyond = 0;
  double legend_u = left;
  for (const PlotSeries& series : plot.series) {
    if (series.points.empty()) continue;
    for (const PlotPoint& point : series.points) beyond += !canvas.holds(point);
    body += series.is_line ? canvas.line(series) : canvas.dots(series);
    legend += fmt::format(R"(<circle cx="{:.0f}" cy="31" r="4" fill="{}"/><text x="{:.0f}" y="35">{}</text>)",
                          legend_u + 4, series.colour, legend_u + 12, escaped(series.name));
    legend_u += 30 + 6.3 * static_cast<double>(series.name.size());
  }
  if (beyond > 0) {
    legend += fmt::format(R"(<text class="m" x="{}" y="35" text-anchor="end">{} beyond the axis</text>)",
                          width - right, beyond);
  }
  return fmt::format(
      R"(<svg viewBox="0 0 {0} {1}" role="img"><text class="h" x="{2}" y="16">{3}</text>{4}{5}{6})"
      R"(<text class="m" x="{7}" y="{8}" text-anchor="middle">{9}</text>)"
      R"svg(<text class="m" transform="translate(14 {10}) rotate(-90)" text-anchor="middle">{11}</text></svg>)svg",
      width, height, left, escaped(plot.title), legend, canvas.grid(), body, (left + width - right) / 2,
      height - 8, escaped(plot.x_label), (top + height - bottom) / 2, escaped(plot.y_label));
}

}  // namespace stevedore
