#include "report/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "report/html.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kWidth = 560, kHeight = 260, kLeft = 62, kRight = 12, kTop = 12, kBottom = 44;
constexpr std::size_t kListed = 40;  ///< abscissae that a table of values still has
constexpr std::size_t kDashes = 6;
constexpr std::size_t kNamed = 12;  ///< names of kinds that have room below a chart

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void hold(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// 1, 2 or 5 times a power of ten, so that about `count` steps make `width`.
double tick_step(double width, int count) {
  const double rough = width / count, power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double step : {1.0, 2.0, 5.0})
    if (rough <= step * power) return step * power;
  return 10 * power;
}

std::string tick_text(double value) { return with_true_minus(formatted("%g", value + 0.0)); }

Span abscissae(const Chart& chart) {
  Span span;
  if (!chart.categories.empty()) return {-0.5, static_cast<double>(chart.categories.size()) - 0.5};
  for (const double x : chart.x) span.hold(x);
  if (!(span.high > span.low)) span = {span.low - 1, span.low + 1};
  return span;
}

Span ordinates(const Chart& chart) {
  Span span;
  span.hold(0);
  for (const ChartSeries& s : chart.series)
    for (std::size_t i = 0; i < s.values.size(); ++i) {
      const double half = s.half_width.empty() || !std::isfinite(s.half_width[i]) ? 0 : s.half_width[i];
      span.hold(s.values[i] - half);
      span.hold(s.values[i] + half);
    }
  if (!(span.high > span.low)) span = {-1, 1};
  const double room = 0.05 * (span.high - span.low);
  return {span.low < 0 ? span.low - room : 0, span.high > 0 ? span.high + room : 0};
}

class Drawing {
 public:
  explicit Drawing(const Chart& chart) : chart_(chart), x_(abscissae(chart)), y_(ordinates(chart)) {}

  std::string svg() const {
    std::string text = "<svg viewBox=\"0 0 560 260\" role=\"img\" aria-label=\"" + escaped(description()) + "\">\n";
    text += axes();
    for (std::size_t k = 0; k < chart_.series.size(); ++k) text += line(k);
    return text + "</svg>\n";
  }

 private:
  double left(double x) const { return kLeft + (kWidth - kLeft - kRight) * (x - x_.low) / (x_.high - x_.low); }
  double top(double y) const { return kTop + (kHeight - kTop - kBottom) * (y_.high - y) / (y_.high - y_.low); }

  /// What a screen reader says in place of the picture.
  std::string description() const {
    std::string text = chart_.title + ". " + chart_.y_label + " over " + chart_.x_label + ".";
    for (const ChartSeries& s : chart_.series) {
      Span span;
      for (const double v : s.values) span.hold(v);
      if (span.high >= span.low)
        text += " " + s.name + ": " + quantity(span.low, std::nullopt, "") + " to " +
                quantity(span.high, std::nullopt, chart_.y_unit) + ".";
    }
    return text;
  }

  static std::string at(double x, double y) { return fixed_text(x, 1) + " " + fixed_text(y, 1); }

  std::string axes() const {
    std::string grid, labels;
    const double dx = tick_step(x_.high - x_.low, 7), dy = tick_step(y_.high - y_.low, 5);
    const auto tick = [&](double x, const std::string& name) {
      grid += "M" + at(left(x), kTop) + "V" + fixed_text(kHeight - kBottom, 1);
      labels +=
          "<text x=\"" + fixed_text(left(x), 1) + "\" y=\"232\" text-anchor=\"middle\">" + escaped(name) + "</text>";
    };
    if (chart_.categories.empty()) {
      for (double k = std::ceil(x_.low / dx); k * dx <= x_.high + 1e-9 * dx; ++k) tick(k * dx, tick_text(k * dx));
    } else {
      const std::size_t every = 1 + (chart_.categories.size() - 1) / kNamed;
      for (std::size_t k = 0; k < chart_.categories.size(); k += every)
        tick(static_cast<double>(k), chart_.categories[k]);
    }
    for (double k = std::ceil(y_.low / dy); k * dy <= y_.high + 1e-9 * dy; ++k) {
      grid += "M" + at(kLeft, top(k * dy)) + "H" + fixed_text(kWidth - kRight, 1);
      labels += "<text x=\"56\" y=\"" + fixed_text(top(k * dy) + 4, 1) + "\" text-anchor=\"end\">" + tick_text(k * dy) +
                "</text>";
    }
    return "<path class=\"grid\" d=\"" + grid + "\"/><path class=\"axis\" d=\"M" + at(kLeft, top(0)) + "H" +
           fixed_text(kWidth - kRight, 1) + "\"/><g class=\"ticks\">" + labels +
           "</g><text x=\"311\" y=\"254\" text-anchor=\"middle\">" + escaped(chart_.x_label) +
           "</text><text transform=\"translate(14 114) rotate(-90)\" text-anchor=\"middle\">" +
           escaped(chart_.y_label) + "</text>\n";
  }

  std::string line(std::size_t k) const {
    const ChartSeries& s = chart_.series[k];
    const std::string look = " s" + std::to_string(k % kDashes);
    std::string path, text;
    if (chart_.marks == ChartMarks::points) {
      for (std::size_t i = 0; i < s.values.size(); ++i)
        if (std::isfinite(s.values[i])) path += "M" + at(left(chart_.x[i]), top(s.values[i])) + "h0";
      return "<path class=\"dots" + look + "\" d=\"" + path + "\"/>\n";
    }
    if (!s.half_width.empty()) text += band(s, look);
    bool open = false;
    for (std::size_t i = 0; i < s.values.size(); ++i) {
      if (std::isfinite(s.values[i])) path += (open ? "L" : "M") + at(left(chart_.x[i]), top(s.values[i]));
      open = std::isfinite(s.values[i]);
    }
    return text + "<path class=\"line" + look + "\" d=\"" + path + "\"/>\n";
  }

  std::string band(const ChartSeries& s, const std::string& look) const {
    std::string path;
    const auto bound = [&](std::size_t i, double sign) {
      const double half = s.half_width[i];
      if (std::isfinite(s.values[i]) && std::isfinite(half))
        path += (path.empty() ? "M" : "L") + at(left(chart_.x[i]), top(s.values[i] + sign * half));
    };
    for (std::size_t i = 0; i < s.values.size(); ++i) bound(i, 1);
    for (std::size_t i = s.values.size(); i-- > 0;) bound(i, -1);
    return path.empty() ? "" : "<path class=\"band" + look + "\" d=\"" + path + "Z\"/>\n";
  }

  const Chart& chart_;
  Span x_, y_;
};

/// Numbers as the page's script wants them: five digits are more than a screen shows.
nlohmann::json numbers(const std::vector<double>& values) {
  nlohmann::json list = nlohmann::json::array();
  for (const double value : values)
    list.push_back(std::isfinite(value) ? nlohmann::json(nlohmann::json::parse(formatted("%.5g", value)).get<double>())
                                        : nlohmann::json());
  return list;
}

nlohmann::json chart_json(const Chart& chart) {
  nlohmann::json json = {{"title", chart.title},
                         {"x_label", chart.x_label},
                         {"y_label", chart.y_label},
                         {"x_name", chart.x_name},
                         {"y_unit", chart.y_unit},
                         {"x", numbers(chart.x)},
                         {"points", chart.marks == ChartMarks::points}};
  if (!chart.categories.empty()) json["categories"] = chart.categories;
  for (const ChartSeries& s : chart.series) {
    nlohmann::json entry = {{"name", s.name}, {"values", numbers(s.values)}};
    if (!s.half_width.empty()) entry["half_width"] = numbers(s.half_width);
    json["series"].push_back(std::move(entry));
  }
  return json;
}

std::string legend(const Chart& chart) {
  std::string text;
  for (std::size_t k = 0; k < chart.series.size(); ++k)
    text += element("li", "<svg viewBox=\"0 0 24 8\" aria-hidden=\"true\"><path class=\"" +
                              std::string(chart.marks == ChartMarks::points ? "dots" : "line") + " s" +
                              std::to_string(k % kDashes) + "\" d=\"" +
                              (chart.marks == ChartMarks::points ? "M12 4h0" : "M0 4H24") + "\"/></svg> " +
                              escaped(chart.series[k].name));
  return element("ul", text, "class=\"legend\"");
}

std::string value_table(const Chart& chart) {
  if (chart.x.size() > kListed) return "";
  std::vector<std::string> head = {escaped(chart.x_label)};
  for (const ChartSeries& s : chart.series) head.push_back(escaped(s.name));
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < chart.x.size(); ++i) {
    std::vector<std::string>& row = rows.emplace_back(1, quantity(chart.x[i], std::nullopt, ""));
    for (const ChartSeries& s : chart.series)
      row.push_back(
          std::isfinite(s.values[i])
              ? quantity(s.values[i], s.half_width.empty() ? std::nullopt : std::optional(s.half_width[i] / 2), "")
              : "–");
  }
  return element("details", element("summary", "Values") + html_table(chart.title + ", " + chart.y_label, head, rows));
}

}  // namespace

std::string chart_figure(const Chart& chart) {
  return element("figure",
                 element("figcaption", escaped(chart.title)) +
                     element("div", Drawing(chart).svg() + legend(chart), "class=\"still\"") +
                     (chart.note.empty() ? "" : element("p", escaped(chart.note), "class=\"note\"")) +
                     script_data(chart_json(chart)) + value_table(chart),
                 "class=\"chart\"");
}

}  // namespace trunnion
