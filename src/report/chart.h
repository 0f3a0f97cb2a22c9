#pragma once

#include <string>
#include <vector>

namespace trunnion {

/// One quantity over the chart's abscissa.
struct ChartSeries {
  std::string name;
  std::vector<double> values;
  std::vector<double> half_width = {};  ///< of a band about the values; empty: none
};

enum class ChartMarks { lines, points };

/// A chart of numbers over numbers: a picture without scripts, alive with them, its values beside it.
struct Chart {
  std::string title;
  std::string x_label, y_label;  ///< with unit: "C, deg"
  std::string x_name, y_unit;    ///< what a reading-out says: "C", "µm"
  std::vector<double> x;         ///< ascending
  std::vector<ChartSeries> series;
  ChartMarks marks = ChartMarks::lines;
  std::vector<std::string> categories = {};  ///< names of x = 0, 1, … where x tells kinds and not numbers
  std::string note = {};                     ///< below the picture: what a band is
};

/// The chart as a figure (HTML): an SVG, the numbers for the page's script, and where there are few a table of them.
std::string chart_figure(const Chart& chart);

}  // namespace trunnion
