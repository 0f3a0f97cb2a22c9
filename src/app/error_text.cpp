#include "app/error_text.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/braille_plot.h"
#include "app/text_table.h"
#include "errormap/error_surface.h"
#include "geometric_errors/symbol.h"

namespace trunnion {
namespace {

constexpr double kLever_mm = 100;

/// What an error displaces a point 100 mm off by, mm.
double reach(const ErrorFinding& e) { return std::abs(e.largest) * (e.unit == Unit::um ? 1 : kLever_mm); }

/// Which of the twelve a symbol is.
std::size_t component_of(const std::string& symbol, char tilt) {
  const char axis = symbol.back();
  std::size_t c = 0;
  while (c < 6 && error_symbol(c, axis) != symbol) ++c;
  return c + (axis == tilt ? 0 : 6);
}

double std_of(const RotaryMapContent& content, std::size_t coefficient) {
  const auto k = static_cast<Eigen::Index>(coefficient);
  if (content.grid_covariance.rows() <= k) return 0;
  return std::sqrt(std::max(0.0, content.grid_covariance(k, k)));
}

bool unseen(const RotaryMapContent& content, std::size_t coefficient) {
  return !content.unseen.empty() && content.unseen[coefficient];
}

}  // namespace

std::string position_text(IndexedPosition at, char tilt, bool with_c) {
  std::string text = std::string(1, tilt) + formatted(" %.6g", at.a.in_degrees());
  if (with_c) text += formatted(" C %.6g", at.c.in_degrees());
  return text;
}

std::string errors_table(const std::vector<ErrorFinding>& errors, char tilt) {
  std::vector<std::vector<std::string>> rows = {{"error", "largest", "std", "unit", "at", "p", "told from zero"}};
  for (const ErrorFinding& e : errors) {
    const bool of_c = e.symbol.back() == 'C';
    if (!e.seen()) {
      rows.push_back({e.symbol, "-", "-", std::string(unit_text(e.unit).text), "-", "-", "not seen"});
      continue;
    }
    rows.push_back(
        {e.symbol, formatted("%.3f", to_unit(e.largest, e.unit)), formatted("%.3f", to_unit(e.largest_std, e.unit)),
         std::string(unit_text(e.unit).text), position_text(e.largest_at, tilt, of_c), p_value_text(e.p_value),
         std::string(e.told_from_zero ? "yes" : "no") +
             (e.unseen > 0 ? ", " + std::to_string(e.unseen) + " of " + std::to_string(e.nodes) + " nodes not seen"
                           : "")});
  }
  return text_table(rows);
}

std::string nodes_table(const RotaryErrorMap& map, char tilt) {
  const RotaryMapContent& content = map.content();
  const ErrorGrid& grid = content.grid;
  const Eigen::VectorXd values = grid.coefficients();
  std::vector<std::vector<std::string>> rows = {{"at"}};
  const auto heading = [&](char axis) {
    rows.push_back({axis == tilt ? std::string(1, tilt) : std::string(1, tilt) + ", C"});
    for (std::size_t c = 0; c < 6; ++c)
      rows.back().push_back(error_symbol(c, axis) + " " + std::string(unit_text(component_unit(c)).text));
  };
  const auto line = [&](const std::string& at, std::size_t offset) {
    rows.push_back({at});
    for (std::size_t c = 0; c < 6; ++c) {
      const Unit unit = component_unit(c);
      rows.back().push_back(unseen(content, offset + c)
                                ? "unseen"
                                : with_uncertainty(to_unit(values[static_cast<Eigen::Index>(offset + c)], unit),
                                                   to_unit(std_of(content, offset + c), unit)));
    }
  };
  rows.clear();
  heading(tilt);
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i)
    line(formatted("%.6g", grid.a_stations[i].in_degrees()), grid.tilt_offset(i));
  heading('C');
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i)
    for (std::size_t j = 0; j < grid.c_stations.size(); ++j)
      line(formatted("%.6g", grid.a_stations[i].in_degrees()) + formatted(", %.6g", grid.c_stations[j].in_degrees()),
           grid.turn_offset(i, j));
  return text_table(rows);
}

const ErrorFinding& worst_error(const std::vector<ErrorFinding>& errors) {
  return *std::ranges::max_element(errors, {}, reach);
}

std::string worst_error_plot(const RotaryErrorMap& map, const std::vector<ErrorFinding>& errors, char tilt) {
  const ErrorFinding& worst = worst_error(errors);
  const RotaryMapContent& content = map.content();
  const ErrorGrid& grid = content.grid;
  const Eigen::VectorXd values = grid.coefficients();
  const std::size_t component = component_of(worst.symbol, tilt);
  const bool of_c = component >= 6;
  const Unit unit = component_unit(component % 6);
  const Angle tilt_there = worst.largest_at.a;
  const Range<Angle> range{grid.a_stations.front(), grid.a_stations.back()};
  Plot plot{.title = "The largest, " + worst.symbol + " in " + std::string(unit_text(unit).text) + ", over " +
                     (of_c ? "C at " + position_text(worst.largest_at, tilt, false) : std::string(1, tilt)) +
                     " (bars: two standard uncertainties at the measured positions)",
            .x_name = of_c ? "C, deg" : std::string(1, tilt) + ", deg",
            .low = of_c ? 0 : range.low.in_degrees(),
            .high = of_c ? 360 : range.high.in_degrees(),
            .curve = {},
            .bars = {}};
  if (!(plot.high > plot.low)) return "";
  // Through the nodes: the smooth surface shares constants between the axes in its own way.
  const std::unique_ptr<ErrorSurface> surface = make_surface(content.interpolation, grid);
  if (std::ranges::none_of(content.unseen, [](bool hidden) { return hidden; }))
    plot.curve = [&](double angle) {
      const IndexedPosition at = of_c ? IndexedPosition{tilt_there, Angle::degrees(angle)}
                                      : IndexedPosition{std::clamp(Angle::degrees(angle), range.low, range.high), {}};
      const RotaryErrors e = surface->at(at);
      return to_unit((of_c ? e.turn : e.tilt).vector()[static_cast<Eigen::Index>(component % 6)], unit);
    };
  const auto bar = [&](double x, std::size_t k) {
    if (!unseen(content, k))
      plot.bars.push_back(
          {x, to_unit(values[static_cast<Eigen::Index>(k)], unit), 2 * to_unit(std_of(content, k), unit)});
  };
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i) {
    if (!of_c) bar(grid.a_stations[i].in_degrees(), grid.tilt_offset(i) + component);
    if (of_c && grid.a_stations[i] == tilt_there)
      for (std::size_t j = 0; j < grid.c_stations.size(); ++j)
        bar(std::remainder(grid.c_stations[j].in_degrees() - 180, 360) + 180, grid.turn_offset(i, j) + component - 6);
  }
  return braille_plot(plot);
}

}  // namespace trunnion
