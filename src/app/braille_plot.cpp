#include "app/braille_plot.h"

#include <algorithm>
#include <cmath>

#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr int kColumns = 60, kRows = 8;  // characters
constexpr int kWide = 2 * kColumns, kHigh = 4 * kRows;

/// Dots of a braille character by column and row (Unicode 2800 to 28FF).
constexpr unsigned kDot[2][4] = {{0x01, 0x02, 0x04, 0x40}, {0x08, 0x10, 0x20, 0x80}};

class Canvas {
 public:
  Canvas() : cells_(static_cast<std::size_t>(kColumns * kRows), 0) {}
  void dot(int x, int y) {
    if (x < 0 || x >= kWide || y < 0 || y >= kHigh) return;
    cells_[static_cast<std::size_t>(y / 4 * kColumns + x / 2)] |= kDot[x % 2][y % 4];
  }
  std::string row(int r) const {
    std::string text;
    for (int c = 0; c < kColumns; ++c) {
      const unsigned bits = cells_[static_cast<std::size_t>(r * kColumns + c)];
      text += static_cast<char>(0xE2);
      text += static_cast<char>(0xA0 | (bits >> 6));
      text += static_cast<char>(0x80 | (bits & 0x3F));
    }
    return text;
  }

 private:
  std::vector<unsigned> cells_;
};

}  // namespace

std::string braille_plot(const Plot& plot) {
  std::vector<double> values;
  for (int x = 0; plot.curve && x < kWide; ++x)
    values.push_back(plot.curve(plot.low + (plot.high - plot.low) * x / (kWide - 1)));
  double bottom = 0, top = 0;
  for (const double value : values) bottom = std::min(bottom, value), top = std::max(top, value);
  for (const PlotBar& bar : plot.bars)
    bottom = std::min(bottom, bar.y - bar.half), top = std::max(top, bar.y + bar.half);
  if (!(top > bottom)) top = bottom + 1;
  const auto row_of = [&](double y) { return static_cast<int>(std::lround((top - y) / (top - bottom) * (kHigh - 1))); };
  Canvas canvas;
  for (int x = 0; x < kWide; x += 4) canvas.dot(x, row_of(0));
  int before = values.empty() ? 0 : row_of(values[0]);
  for (int x = 0; x < static_cast<int>(values.size()); ++x) {  // steep parts without gaps
    const int here = row_of(values[static_cast<std::size_t>(x)]);
    const int from = here > before ? std::min(before + 1, here) : std::max(before - 1, here);
    for (int y = std::min(from, here); y <= std::max(from, here); ++y) canvas.dot(x, y);
    before = here;
  }
  for (const PlotBar& bar : plot.bars) {
    const int x = static_cast<int>(std::lround((bar.x - plot.low) / (plot.high - plot.low) * (kWide - 1)));
    for (int y = row_of(bar.y + bar.half); y <= row_of(bar.y - bar.half); ++y) canvas.dot(x, y);
  }
  std::vector<std::string> labels(kRows);
  labels.back() = formatted("%.3g", bottom);
  labels[static_cast<std::size_t>(row_of(0) / 4)] = "0";
  labels.front() = row_of(0) / 4 == 0 ? "0" : formatted("%.3g", top);
  if (row_of(0) / 4 == kRows - 1) labels.back() = "0";
  std::size_t width = 0;
  for (const std::string& label : labels) width = std::max(width, label.size());
  std::string text = plot.title + "\n";
  for (int r = 0; r < kRows; ++r) {
    const std::string& label = labels[static_cast<std::size_t>(r)];
    text +=
        "  " + std::string(width - label.size(), ' ') + label + (label.empty() ? " │" : " ┤") + canvas.row(r) + "\n";
  }
  const std::string low = formatted("%.4g", plot.low), high = formatted("%.4g", plot.high);
  std::string below = low;
  const std::size_t name_at = kColumns / 2 - plot.x_name.size() / 2;
  below += std::string(name_at > below.size() ? name_at - below.size() : 1, ' ') + plot.x_name;
  below += std::string(below.size() + high.size() < kColumns ? kColumns - below.size() - high.size() : 1, ' ') + high;
  return text + std::string(width + 4, ' ') + below + "\n";
}

}  // namespace trunnion
