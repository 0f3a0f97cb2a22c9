#include "report/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kWidth = 520, kHeight = 240, kLeft = 62, kRight = 12, kTop = 12, kBottom = 44;

struct Scale {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double v) {
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  void settle() {
    if (!(low <= high)) low = 0, high = 1;
    if (high - low < 1e-12 * (1 + std::abs(high))) low -= 1, high += 1;
  }
};

double tick_step(const Scale& s) {
  const double rough = (s.high - s.low) / 5, power = std::pow(10, std::floor(std::log10(rough)));
  for (const double m : {1.0, 2.0, 5.0})
    if (m * power >= rough) return m * power;
  return 10 * power;
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string still_svg(const Chart& chart) {
  Scale x, y;
  for (const double v : chart.x) x.take(v);
  for (const ChartSeries& s : chart.series)
    for (std::size_t k = 0; k < s.y.size(); ++k) {
      const double half = s.half_width.empty() ? 0 : s.half_width[k];
      y.take(s.y[k] - half), y.take(s.y[k] + half);
    }
  y.take(0);
  x.settle(), y.settle();
  const auto px = [&](double v) { return kLeft + (v - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight); };
  const auto py = [&](double v) {
    return kHeight - kBottom - (v - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  };
  const auto n = [](double v) { return formatted("%.1f", v); };
  std::string svg = "<svg viewBox=\"0 0 " + n(kWidth) + " " + n(kHeight) + "\" role=\"img\" aria-label=\"" +
                    escaped(chart.title) + "\"><g class=\"axes\">";
  for (double v = std::ceil(y.low / tick_step(y)) * tick_step(y); v <= y.high + 1e-12; v += tick_step(y))
    svg += "<path d=\"M" + n(kLeft) + " " + n(py(v)) + "H" + n(kWidth - kRight) + "\"/><text x=\"" + n(kLeft - 6) +
           "\" y=\"" + n(py(v) + 4) + "\" text-anchor=\"end\">" + formatted("%.4g", std::abs(v) < 1e-12 ? 0 : v) +
           "</text>";
  for (double v = std::ceil(x.low / tick_step(x)) * tick_step(x); v <= x.high + 1e-12; v += tick_step(x))
    svg += "<text x=\"" + n(px(v)) + "\" y=\"" + n(kHeight - kBottom + 16) + "\" text-anchor=\"middle\">" +
           formatted("%.4g", std::abs(v) < 1e-12 ? 0 : v) + "</text>";
  svg += "<text x=\"" + n((kLeft + kWidth) / 2) + "\" y=\"" + n(kHeight - 6) + "\" text-anchor=\"middle\">" +
         escaped(chart.x_label) + "</text><text transform=\"translate(14 " + n(kHeight / 2) +
         ") rotate(-90)\" text-anchor=\"middle\">" + escaped(chart.y_label) + "</text></g>";
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const ChartSeries& s = chart.series[i];
    const std::string colour = "s" + std::to_string(i % 8);
    if (!s.half_width.empty()) {
      std::string edge, back;
      for (std::size_t k = 0; k < s.y.size(); ++k) {
        if (!std::isfinite(s.y[k])) continue;
        edge += n(px(chart.x[k])) + " " + n(py(s.y[k] + s.half_width[k])) + " ";
        back = n(px(chart.x[k])) + " " + n(py(s.y[k] - s.half_width[k])) + " " + back;
      }
      svg += "<polygon class=\"band " + colour + "\" points=\"" + edge + back + "\"/>";
    }
    if (chart.points) {
      svg += "<path class=\"dots " + colour + "\" d=\"";
      for (std::size_t k = 0; k < s.y.size(); ++k)
        if (std::isfinite(s.y[k])) svg += "M" + n(px(chart.x[k])) + " " + n(py(s.y[k])) + "h0";
      svg += "\"/>";
    } else {
      svg += "<polyline class=\"" + colour + "\" points=\"";
      for (std::size_t k = 0; k < s.y.size(); ++k)
        if (std::isfinite(s.y[k])) svg += n(px(chart.x[k])) + " " + n(py(s.y[k])) + " ";
      svg += "\"/>";
    }
  }
  return svg + "</svg>";
}

std::string chart_json(const Chart& chart) {
  const auto numbers = [](const std::vector<double>& values) {
    nlohmann::json list = nlohmann::json::array();
    for (const double v : values)
      list.push_back(std::isfinite(v) ? nlohmann::json(std::stod(formatted("%.5g", v))) : nlohmann::json());
    return list;
  };
  nlohmann::json series = nlohmann::json::array();
  for (const ChartSeries& s : chart.series)
    series.push_back({{"name", s.name}, {"y", numbers(s.y)}, {"half", numbers(s.half_width)}});
  return nlohmann::json({{"title", chart.title},
                         {"x_label", chart.x_label},
                         {"y_label", chart.y_label},
                         {"points", chart.points},
                         {"x", numbers(chart.x)},
                         {"series", series}})
      .dump();
}

}  // namespace trunnion
