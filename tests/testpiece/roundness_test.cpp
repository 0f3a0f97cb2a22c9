#include "testpiece/roundness.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "error.h"
#include "support/noise.h"
#include "units/angle.h"

namespace trunnion {
namespace {

constexpr double kRounding_mm = 1e-12;  // far above double rounding on 40 mm, far below any measurement

RoundnessTrace even_trace(std::size_t points, double radius_mm, auto radial_mm) {
  RoundnessTrace trace{.nominal_radius_mm = radius_mm};
  for (std::size_t i = 0; i < points; ++i) {
    const double phi = kTurn_rad * static_cast<double>(i) / static_cast<double>(points);
    trace.phi_rad.push_back(phi);
    trace.radial_mm.push_back(radial_mm(phi));
  }
  return trace;
}

/// A true circle seen from a nominal centre that it does not stand on.
RoundnessTrace eccentric_circle(double nominal_mm, double radius_mm, Eigen::Vector2d center) {
  return even_trace(73, nominal_mm, [&](double phi) {
    const Eigen::Vector2d e(std::cos(phi), std::sin(phi));
    const double along = center.dot(e), across = center.x() * e.y() - center.y() * e.x();
    return along + std::sqrt(radius_mm * radius_mm - across * across) - nominal_mm;
  });
}

RoundnessTrace rough_trace(std::uint64_t seed, std::size_t points) {
  testing::Noise noise(seed);
  double a[6], b[6];
  for (int k = 0; k < 6; ++k) a[k] = noise.normal() / (k + 1), b[k] = noise.normal() / (k + 1);
  return even_trace(points, 35, [&](double phi) {
    double r = 1e-3 * noise.normal();
    for (int k = 0; k < 6; ++k) r += 5e-3 * (a[k] * std::cos(k * phi) + b[k] * std::sin(k * phi));
    return r;
  });
}

TEST(Roundness, ATrueCircleIsRoundWhereverItStands) {
  const Eigen::Vector2d center(0.4, -0.7);
  const RoundnessTrace trace = eccentric_circle(40, 40.125, center);
  for (const ReferenceCircle& circle : {least_squares_circle(trace), minimum_zone_circle(trace),
                                        maximum_inscribed_circle(trace), minimum_circumscribed_circle(trace)}) {
    EXPECT_NEAR(circle.roundness_mm, 0, kRounding_mm);
    EXPECT_NEAR(circle.size_mm, 0.125, kRounding_mm);
    EXPECT_NEAR((circle.center_mm - center).norm(), 0, 1e-10);
  }
}

TEST(Roundness, ThreeLobesAreReadAtTheirFullHeightByAllFourCircles) {
  const RoundnessTrace trace = even_trace(360, 30, [](double phi) { return 4e-3 * std::cos(3 * phi); });
  for (const ReferenceCircle& circle : {least_squares_circle(trace), minimum_zone_circle(trace),
                                        maximum_inscribed_circle(trace), minimum_circumscribed_circle(trace)})
    EXPECT_NEAR(circle.roundness_mm, 8e-3, kRounding_mm);
  EXPECT_NEAR(minimum_circumscribed_circle(trace).size_mm, 4e-3, kRounding_mm);
  EXPECT_NEAR(maximum_inscribed_circle(trace).size_mm, -4e-3, kRounding_mm);
  EXPECT_NEAR(minimum_zone_circle(trace).size_mm, 0, kRounding_mm);
}

TEST(Roundness, APerfectTraceNeedsNoSteps) {
  const RoundnessTrace trace = even_trace(12, 30, [](double) { return 0.0; });
  EXPECT_EQ(minimum_zone_circle(trace).roundness_mm, 0);
  EXPECT_EQ(least_squares_circle(trace).roundness_mm, 0);
  EXPECT_EQ(maximum_inscribed_circle(trace).center_mm.norm(), 0);
}

/// Descends from `start` by halving steps in eight directions until they are below rounding.
double least_by_search(const auto& value, Eigen::Vector2d at, double step) {
  double best = value(at);
  while (step > 1e-13) {
    bool moved = false;
    for (int k = 0; k < 64; ++k) {
      const Eigen::Vector2d to =
          at + step * Eigen::Vector2d(std::cos(kTurn_rad * k / 64), std::sin(kTurn_rad * k / 64));
      if (const double v = value(to); v < best) best = v, at = to, moved = true;
    }
    if (!moved) step /= 2;
  }
  return best;
}

TEST(Roundness, NoCentreNearbyGivesANarrowerZoneThanTheMinimumZone) {
  constexpr double kSearch_mm = 1e-9;  // what the pattern search itself reaches in a narrow valley
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const RoundnessTrace trace = rough_trace(seed, 90);
    const ReferenceCircle zone = minimum_zone_circle(trace);
    const double searched = least_by_search([&](const Eigen::Vector2d& c) { return roundness_about_mm(trace, c); },
                                            least_squares_circle(trace).center_mm, 1e-2);
    EXPECT_LE(zone.roundness_mm, searched + kRounding_mm) << "seed " << seed;
    EXPECT_NEAR(zone.roundness_mm, searched, 2e-5) << "seed " << seed;
    const double from_zone =
        least_by_search([&](const Eigen::Vector2d& c) { return roundness_about_mm(trace, c); }, zone.center_mm, 1e-3);
    EXPECT_NEAR(from_zone, zone.roundness_mm, kSearch_mm) << "seed " << seed;
  }
}

/// Farthest and nearest points of the zone, in the order of phi: + and -.
std::string contacts(const RoundnessTrace& trace, const ReferenceCircle& zone) {
  std::vector<double> r;
  for (std::size_t i = 0; i < trace.phi_rad.size(); ++i) {
    const Eigen::Vector2d e(std::cos(trace.phi_rad[i]), std::sin(trace.phi_rad[i]));
    r.push_back(((trace.nominal_radius_mm + trace.radial_mm[i]) * e - zone.center_mm).norm());
  }
  const auto [low, high] = std::ranges::minmax(r);
  std::string marks;
  for (const double v : r) {
    if (v > high - 1e-11) marks += '+';
    if (v < low + 1e-11) marks += '-';
  }
  return marks;
}

TEST(Roundness, TheMinimumZoneTouchesOutsideAndInsideByTurns) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const RoundnessTrace trace = rough_trace(seed, 120);
    EXPECT_THAT(contacts(trace, minimum_zone_circle(trace)), ::testing::AnyOf("+-+-", "-+-+")) << "seed " << seed;
  }
}

TEST(Roundness, CirclesOrderAsTheirDefinitionsSay) {
  for (std::uint64_t seed = 30; seed < 50; ++seed) {
    const RoundnessTrace trace = rough_trace(seed, 360);
    const ReferenceCircle lsc = least_squares_circle(trace), mzc = minimum_zone_circle(trace);
    const ReferenceCircle mic = maximum_inscribed_circle(trace), mcc = minimum_circumscribed_circle(trace);
    for (const ReferenceCircle& other : {lsc, mic, mcc})
      EXPECT_LE(mzc.roundness_mm, other.roundness_mm + kRounding_mm) << "seed " << seed;
    EXPECT_LT(mic.size_mm, lsc.size_mm);
    EXPECT_GT(mcc.size_mm, lsc.size_mm);
    // No circle about all points is smaller, none within them larger, wherever its centre.
    const auto largest = [&](const Eigen::Vector2d& c, double sign) {
      double most = -1e9;
      for (std::size_t i = 0; i < trace.phi_rad.size(); ++i) {
        const Eigen::Vector2d e(std::cos(trace.phi_rad[i]), std::sin(trace.phi_rad[i]));
        most = std::max(most, sign * (((35 + trace.radial_mm[i]) * e - c).norm() - 35));
      }
      return most;
    };
    EXPECT_NEAR(least_by_search([&](const Eigen::Vector2d& c) { return largest(c, 1); }, mcc.center_mm, 1e-3),
                mcc.size_mm, 1e-9);
    EXPECT_NEAR(-least_by_search([&](const Eigen::Vector2d& c) { return largest(c, -1); }, mic.center_mm, 1e-3),
                mic.size_mm, 1e-9);
  }
}

TEST(Roundness, OrderAndSpacingOfThePointsDoNotMatter) {
  RoundnessTrace trace = rough_trace(7, 240), shuffled{.nominal_radius_mm = trace.nominal_radius_mm};
  for (std::size_t i = 0; i < 240; ++i) {
    shuffled.phi_rad.push_back(trace.phi_rad[(i * 77) % 240] - 3 * kTurn_rad);
    shuffled.radial_mm.push_back(trace.radial_mm[(i * 77) % 240]);
  }
  EXPECT_NEAR(minimum_zone_circle(shuffled).roundness_mm, minimum_zone_circle(trace).roundness_mm, kRounding_mm);
  EXPECT_NEAR(minimum_circumscribed_circle(shuffled).size_mm, minimum_circumscribed_circle(trace).size_mm,
              kRounding_mm);
}

TEST(Roundness, RefusesATraceThatDoesNotGoRound) {
  RoundnessTrace half{.nominal_radius_mm = 10};
  for (int i = 0; i <= 18; ++i) half.phi_rad.push_back(i * std::numbers::pi / 18), half.radial_mm.push_back(0);
  EXPECT_THROW(minimum_zone_circle(half), InputError);
  EXPECT_THROW(least_squares_circle({.nominal_radius_mm = 10, .phi_rad = {0, 2, 4}, .radial_mm = {0, 0, 0}}),
               InputError);
  // A nominal radius left out.
  EXPECT_THROW(least_squares_circle(even_trace(12, 0, [](double phi) { return 1e-3 * std::cos(2 * phi); })),
               InputError);
  EXPECT_THROW(minimum_zone_circle(even_trace(12, 5, [](double phi) { return 6 * std::cos(phi); })), InputError);
}

}  // namespace
}  // namespace trunnion
