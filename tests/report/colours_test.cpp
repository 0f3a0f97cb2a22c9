#include <gmock/gmock.h>

#include <map>
#include <regex>
#include <string>
#include <vector>

#include "report/web_assets.h"
#include "support/colour_vision.h"
#include "testpiece/colour_scale.h"
#include "testpiece/plots.h"

namespace trunnion {
namespace {

using testing::ciede2000;
using testing::contrast;
using testing::kVisions;
using testing::least_difference;
using testing::seen;
using testing::Srgb;

// In CIEDE2000; 1 is what a trained eye just tells apart on large fields, and a thin line takes many times that.
constexpr double kOfThree = 20, kOfSix = 12;
constexpr double kLineContrast = 3, kTextContrast = 4.5;  // WCAG 2.2, 1.4.11 and 1.4.3 (AA)
constexpr std::size_t kSeries = 6;

/// "#1b2f3c" or "#fff".
Srgb colour_of(const std::string& hex) {
  const std::size_t digits = hex.size() == 4 ? 1 : 2;
  Srgb colour{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = std::stoi(hex.substr(1 + digits * i, digits), nullptr, 16);
    colour[i] = digits == 1 ? 17 * value : value;
  }
  return colour;
}

using Theme = std::map<std::string, Srgb>;

/// The colours by name of each block of the style that sets them: light, dark by the system, dark by choice, printed.
std::vector<Theme> themes() {
  const std::string style(page_style());
  const std::regex block(R"(\{[^{}]*--s0:[^{}]*\})"), setting(R"(--([a-z0-9-]+):\s*(#[0-9a-f]+))");
  std::vector<Theme> found;
  for (auto at = std::sregex_iterator(style.begin(), style.end(), block); at != std::sregex_iterator(); ++at) {
    const std::string text = at->str();
    Theme& theme = found.emplace_back();
    for (auto s = std::sregex_iterator(text.begin(), text.end(), setting); s != std::sregex_iterator(); ++s)
      theme[(*s)[1]] = colour_of((*s)[2]);
  }
  return found;
}

/// Charts draw their series in this order, most of them three or fewer.
void expect_told_apart(const std::vector<Srgb>& series, const Srgb& paper, const std::string& where) {
  ASSERT_EQ(series.size(), kSeries) << where;
  for (std::size_t i = 0; i < kSeries; ++i) {
    EXPECT_GE(contrast(series[i], paper), kLineContrast) << where << ": series " << i << " on paper";
    for (std::size_t j = i + 1; j < kSeries; ++j)
      EXPECT_GE(least_difference(series[i], series[j]), j < 3 ? kOfThree : kOfSix)
          << where << ": series " << i << " and " << j;
  }
}

TEST(ColourVision, ReproducesThePublishedDifferences) {
  constexpr double kPrinted = 5e-5;  // the table has four decimals
  // Sharma, Wu & Dalal (2005), Table 1, pairs 1, 7, 16, 17, 25 and 34.
  EXPECT_NEAR(ciede2000({50, 2.6772, -79.7751}, {50, 0, -82.7485}), 2.0425, kPrinted);
  EXPECT_NEAR(ciede2000({50, 0, 0}, {50, -1, 2}), 2.3669, kPrinted);
  EXPECT_NEAR(ciede2000({50, 2.5, 0}, {50, 0, -2.5}), 4.3065, kPrinted);
  EXPECT_NEAR(ciede2000({50, 2.5, 0}, {73, 25, -18}), 27.1492, kPrinted);
  EXPECT_NEAR(ciede2000({60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}), 1.2644, kPrinted);
  EXPECT_NEAR(ciede2000({2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}), 0.9082, kPrinted);
}

TEST(ColourVision, SeesGreyAsItIsAndRedBesideGreenNot) {
  for (const testing::Vision vision : kVisions)
    EXPECT_LT(ciede2000(seen({128, 128, 128}, vision), seen({128, 128, 128}, testing::Vision::normal)), 0.1);
  const Srgb red = {190, 90, 60}, green = {110, 110, 60};
  EXPECT_GT(ciede2000(seen(red, testing::Vision::normal), seen(green, testing::Vision::normal)), 30);
  EXPECT_LT(ciede2000(seen(red, testing::Vision::deuteranopia), seen(green, testing::Vision::deuteranopia)), 15);
}

TEST(PageColours, AreToldApartByTheColourBlindInEveryTheme) {
  const std::vector<Theme> found = themes();
  ASSERT_EQ(found.size(), 4U);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Theme& theme = found[k];
    const std::string where = "theme " + std::to_string(k);
    std::vector<Srgb> series;
    for (std::size_t i = 0; i < kSeries; ++i) series.push_back(theme.at("s" + std::to_string(i)));
    expect_told_apart(series, theme.at("paper"), where);
    for (const char* text : {"ink", "soft", "link"})
      for (const char* ground : {"paper", "card"})
        EXPECT_GE(contrast(theme.at(text), theme.at(ground)), kTextContrast)
            << where << ": " << text << " on " << ground;
    EXPECT_GE(contrast(theme.at("ink"), theme.at("warn")), kTextContrast) << where;
  }
}

TEST(PlotColours, AreToldApartByTheColourBlind) {
  PolarCurve curve{.label = "a"};
  for (int i = 0; i < 36; ++i) {
    curve.radial.phi_rad.push_back(i * 0.1745);
    curve.radial.radial_mm.push_back(20 + 1e-3 * (i % 5));
  }
  const std::string svg = polar_plot_svg("t", std::vector<PolarCurve>(kSeries, curve));
  std::map<std::string, Srgb> strokes;
  const std::regex line("class=\"line (s[0-9])\"[^>]*stroke=\"(#[0-9a-f]+)\"");
  for (auto at = std::sregex_iterator(svg.begin(), svg.end(), line); at != std::sregex_iterator(); ++at)
    strokes[(*at)[1]] = colour_of((*at)[2]);
  std::vector<Srgb> series;
  for (const auto& [name, stroke] : strokes) series.push_back(stroke);
  expect_told_apart(series, {255, 255, 255}, "polar plot");
}

/// Of the deviation's sign at one size, and of its size at one sign.
TEST(DeviationColours, TellSignAndSizeToTheColourBlind) {
  constexpr double kSign = 20, kStep = 2;
  const auto at = [](double share) {
    const Colour colour = deviation_colour(share);
    return Srgb{double(colour[0]), double(colour[1]), double(colour[2])};
  };
  for (double size = 0.25; size <= 1; size += 0.125) EXPECT_GE(least_difference(at(size), at(-size)), kSign) << size;
  for (const double sign : {-1.0, 1.0})
    for (double size = 0; size < 0.95; size += 0.1)
      for (const testing::Vision vision : kVisions) {
        const auto from_zero = [&](double share) { return ciede2000(seen(at(share), vision), seen(at(0), vision)); };
        EXPECT_GE(from_zero(sign * (size + 0.1)), from_zero(sign * size) + kStep)
            << sign * size << " vision " << static_cast<int>(vision);
      }
}

}  // namespace
}  // namespace trunnion
