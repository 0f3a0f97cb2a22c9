#pragma once

#include <functional>
#include <string>
#include <vector>

namespace trunnion {

/// A measured value on a plot, with what it may be off either way.
struct PlotBar {
  double x = 0, y = 0, half = 0;
};

/// What is drawn: a curve from `low` to `high`, and bars on top.
struct Plot {
  std::string title, x_name;
  double low = 0, high = 1;
  std::function<double(double)> curve;  ///< may be empty: bars alone
  std::vector<PlotBar> bars;
};

/// A plot in lines of text: two by four dots of braille a character, the value axis to the left reaching over all
/// values and zero, a dotted line at zero, the ends of the angle below.
std::string braille_plot(const Plot& plot);

}  // namespace trunnion
