// Plots as inline SVG: no script, no network, the same in every browser.
#pragma once

#include <string>
#include <vector>

namespace stevedore {

struct PlotPoint {
  double x = 0, y = 0;
};

struct PlotSeries {
  std::string name;
  std::string colour;  ///< of CSS
  bool is_line = false;
  std::vector<PlotPoint> points;
  double gap = 1e9;  ///< a line breaks where x jumps by more
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool is_log_y = false;              ///< then y is log10 of the value
  double least_y = 0, largest_y = 0;  ///< equal: from the values, but for the most extreme 1 %
};

/// Empty for a plot without points. Points beyond the axes are counted below the title.
std::string svg_of(const Plot& plot);

/// For text in HTML.
std::string escaped(const std::string& text);

}  // namespace stevedore
