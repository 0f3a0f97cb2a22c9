#include "testpiece/plots.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "testpiece/colour_scale.h"
#include "units/angle.h"

namespace trunnion {
namespace {

constexpr const char* kInks[] = {"#336dbb", "#d5600b", "#144930", "#a8457f", "#3993cf", "#725200"};

std::string fixed(double value, int decimals) {
  char text[64];
  const auto end =
      std::to_chars(text, text + sizeof text, value == 0 ? 0.0 : value, std::chars_format::fixed, decimals);
  const std::string found(text, end.ptr);
  return found.find_first_not_of("-0.") == std::string::npos && found[0] == '-' ? found.substr(1) : found;
}

/// A round number as people write it.
std::string plain(double value) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  return out;
}

std::string opening(int width, int height, const std::string& title) {
  const std::string w = std::to_string(width), h = std::to_string(height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + w + "\" height=\"" + h + "\" viewBox=\"0 0 " + w + " " +
         h + "\" font-family=\"sans-serif\" font-size=\"12\" role=\"img\">\n<title>" + escaped(title) +
         "</title>\n<rect class=\"paper\" width=\"" + w + "\" height=\"" + h + "\" fill=\"#fff\"/>\n";
}

std::string label(double x, double y, const std::string& text, const std::string& more = "") {
  return "<text x=\"" + fixed(x, 1) + "\" y=\"" + fixed(y, 1) + "\" " + more + ">" + escaped(text) + "</text>\n";
}

/// Lines are told apart by colour and, by those who see no colours, by their dashes.
std::string line_style(std::size_t k) {
  constexpr const char* kDashes[] = {"", "8 4", "2 3", "10 3 2 3", "5 5", "1 4"};
  k %= std::size(kInks);
  return "class=\"line s" + std::to_string(k) + "\" fill=\"none\" stroke=\"" + kInks[k] + "\" stroke-width=\"1.5\"" +
         (k == 0 ? "" : std::string(" stroke-dasharray=\"") + kDashes[k] + "\"");
}

std::string hex(Colour colour) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text = "#";
  for (const std::uint8_t c : colour) text += {kDigits[c >> 4U], kDigits[c & 15U]};
  return text;
}

}  // namespace

std::string polar_plot_svg(const std::string& title, std::span<const PolarCurve> curves) {
  constexpr double kCenter = 260, kCircle = 150, kReach = 80;
  std::vector<std::vector<double>> residual_um;
  double largest = 0;
  for (const PolarCurve& curve : curves) {
    const ReferenceCircle lsc = least_squares_circle(curve.radial);
    std::vector<double>& line = residual_um.emplace_back();
    for (std::size_t i = 0; i < curve.radial.phi_rad.size(); ++i) {
      const double phi = curve.radial.phi_rad[i];
      line.push_back(1e3 * (curve.radial.radial_mm[i] - lsc.size_mm - lsc.center_mm.x() * std::cos(phi) -
                            lsc.center_mm.y() * std::sin(phi)));
      largest = std::max(largest, std::abs(line.back()));
    }
  }
  const double division_um = round_scale(largest) / 2, scale = kReach / (2 * division_um);

  std::string svg = opening(520, 560 + 18 * static_cast<int>(curves.size()), title);
  svg += label(12, 22, title, "font-size=\"14\"");
  for (int ring = -2; ring <= 2; ++ring)
    svg += "<circle cx=\"260\" cy=\"260\" r=\"" + fixed(kCircle + ring * kReach / 2, 1) + "\" fill=\"none\" " +
           (ring == 0 ? "class=\"axis\" stroke=\"#555\"" : "class=\"grid\" stroke=\"#ccc\"") + "/>\n";
  for (int k = 0; k < 12; ++k) {
    const double phi = kTurn_rad * k / 12;
    const auto at = [&](double r) { return std::pair(kCenter + r * std::cos(phi), kCenter - r * std::sin(phi)); };
    const auto [x, y] = at(kCircle + kReach + 14);
    const auto [x1, y1] = at(kCircle - kReach);
    const auto [x2, y2] = at(kCircle + kReach);
    svg += "<path d=\"M" + fixed(x1, 1) + " " + fixed(y1, 1) + "L" + fixed(x2, 1) + " " + fixed(y2, 1) +
           "\" class=\"grid\" stroke=\"#e5e5e5\"/>\n";
    svg += label(x, y + 4, std::to_string(30 * k), "text-anchor=\"middle\" fill=\"#555\"");
  }
  for (std::size_t c = 0; c < curves.size(); ++c) {
    std::string path;
    for (std::size_t i = 0; i < residual_um[c].size(); ++i) {
      const double r = kCircle + scale * residual_um[c][i], phi = curves[c].radial.phi_rad[i];
      path += (path.empty() ? "M" : "L") + fixed(kCenter + r * std::cos(phi), 2) + " " +
              fixed(kCenter - r * std::sin(phi), 2);
    }
    const std::string line = line_style(c);
    svg += "<path d=\"" + path + "Z\" " + line + "/>\n";
    const double y = 550 + 18 * static_cast<double>(c);
    svg += "<path d=\"M30 " + fixed(y - 6, 1) + "h28\" " + line + "/>\n";
    svg += label(66, y - 2,
                 curves[c].label + ": LSC " + fixed(1e3 * least_squares_circle(curves[c].radial).roundness_mm, 3) +
                     " µm, MZC " + fixed(1e3 * minimum_zone_circle(curves[c].radial).roundness_mm, 3) + " µm");
  }
  svg += label(40, 526, "1 division = " + plain(division_um) + " µm, about the least squares circle; phi in deg",
               "fill=\"#333\"");
  return svg + "</svg>\n";
}

std::string unrolled_map_svg(const std::string& title, std::size_t phi_count, std::span<const double> heights_mm,
                             std::span<const double> deviation_mm, double end_um) {
  constexpr double kLeft = 60, kTop = 40, kWidth = 470, kHeight = 160, kBar = kLeft + kWidth + 20;
  const auto rows = static_cast<double>(heights_mm.size());
  const double cell_x = kWidth / static_cast<double>(phi_count), cell_y = kHeight / rows;

  std::string svg = opening(640, 260, title);
  svg += label(kLeft, 24, title, "font-size=\"14\"");
  svg += "<g shape-rendering=\"crispEdges\">\n";
  for (std::size_t j = 0; j < heights_mm.size(); ++j) {
    const std::string y = fixed(kTop + kHeight - (static_cast<double>(j) + 1) * cell_y, 2);
    for (std::size_t k = 0; k < phi_count;) {
      // Neighbours of one colour make one rectangle.
      const Colour colour = deviation_colour(1e3 * deviation_mm[j * phi_count + k] / end_um);
      std::size_t to = k + 1;
      while (to < phi_count && deviation_colour(1e3 * deviation_mm[j * phi_count + to] / end_um) == colour) ++to;
      svg += "<rect x=\"" + fixed(kLeft + static_cast<double>(k) * cell_x, 2) + "\" y=\"" + y + "\" width=\"" +
             fixed(static_cast<double>(to - k) * cell_x, 2) + "\" height=\"" + fixed(cell_y, 2) + "\" fill=\"" +
             hex(colour) + "\"/>\n";
      k = to;
    }
  }
  svg += "</g>\n";
  for (int k = 0; k <= 360; k += 45)
    svg += label(kLeft + kWidth * k / 360, kTop + kHeight + 16, std::to_string(k), "text-anchor=\"middle\"");
  svg += label(kLeft + kWidth / 2, kTop + kHeight + 34, "phi, deg", "text-anchor=\"middle\"");
  for (const std::size_t j : {std::size_t{0}, heights_mm.size() - 1})
    svg += label(kLeft - 6, kTop + kHeight - (static_cast<double>(j) + 0.5) * cell_y + 4, fixed(heights_mm[j], 1),
                 "text-anchor=\"end\"");
  svg += label(8, kTop + kHeight / 2, "h, mm");
  for (int k = 0; k < 64; ++k)
    svg += "<rect x=\"" + plain(kBar) + "\" y=\"" + fixed(kTop + kHeight * (63 - k) / 64, 2) +
           "\" width=\"18\" height=\"" + fixed(kHeight / 64 + 0.3, 2) + "\" fill=\"" +
           hex(deviation_colour((k + 0.5) / 32 - 1)) + "\"/>\n";
  for (const double share : {-1.0, 0.0, 1.0})
    svg += label(kBar + 24, kTop + kHeight * (1 - share) / 2 + 4,
                 (share > 0   ? "+"
                  : share < 0 ? "−"
                              : "") +
                     plain(std::abs(share) * end_um) + " µm");
  return svg + "</svg>\n";
}

}  // namespace trunnion
