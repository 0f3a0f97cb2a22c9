#pragma once

#include <string>
#include <vector>

namespace trunnion {

/// One curve, or one cloud of points, over the x of its chart; NaN: nothing there.
struct ChartSeries {
  std::string name;
  std::vector<double> y;
  std::vector<double> half_width;  ///< of a band about y; may be empty
};

/// A picture of numbers, drawn twice: once as a still that needs nothing, once alive by the page's script.
struct Chart {
  std::string title, x_label, y_label;  ///< labels with their units
  bool points = false;                  ///< a cloud; else curves
  std::vector<double> x;                ///< ascending
  std::vector<ChartSeries> series;
};

/// The still: SVG without outside references, colours by the page's style.
std::string still_svg(const Chart& chart);
/// What the script draws (JSON).
std::string chart_json(const Chart& chart);

/// Text that may stand in HTML and in attributes.
std::string escaped(const std::string& text);

}  // namespace trunnion
