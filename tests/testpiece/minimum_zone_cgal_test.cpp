#include <CGAL/Exact_integer.h>
#include <CGAL/Gmpzf.h>
#include <CGAL/Min_annulus_d.h>
#include <CGAL/Min_sphere_annulus_d_traits_2.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/noise.h"
#include "testpiece/roundness.h"

namespace trunnion {
namespace {

/// The narrowest annulus in squared radii, R^2 - r^2, exact.
Eigen::Vector2d annulus_center(const RoundnessTrace& trace) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Traits = CGAL::Min_sphere_annulus_d_traits_2<Kernel, CGAL::Gmpzf, double>;
  std::vector<Kernel::Point_2> points;
  for (std::size_t i = 0; i < trace.phi_rad.size(); ++i) {
    const double r = trace.nominal_radius_mm + trace.radial_mm[i];
    points.emplace_back(r * std::cos(trace.phi_rad[i]), r * std::sin(trace.phi_rad[i]));
  }
  const CGAL::Min_annulus_d<Traits> annulus(points.begin(), points.end());
  auto at = annulus.center_coordinates_begin();
  const double x = CGAL::to_double(*at++), y = CGAL::to_double(*at++), scale = CGAL::to_double(*at);
  return {x / scale, y / scale};
}

/// With w the minimum zone and m its mean radius, the annulus has w' m' <= w m: its width exceeds w by no more than
/// the mean radii differ, 1 part in 500 here.
TEST(MinimumZone, IsThatOfCgalsAnnulusButForSquaredRadii) {
  constexpr double kRounding_mm = 1e-11;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    testing::Noise noise(seed);
    RoundnessTrace trace{.nominal_radius_mm = 35};
    for (int i = 0; i < 240; ++i) {
      const double phi = 2 * std::numbers::pi * i / 240;
      trace.phi_rad.push_back(phi);
      trace.radial_mm.push_back(8e-3 * std::cos(phi - 1) + 5e-3 * std::cos(2 * phi) + 3e-3 * std::sin(3 * phi) +
                                2e-3 * noise.normal());
    }
    const ReferenceCircle zone = minimum_zone_circle(trace);
    const double annulus = roundness_about_mm(trace, annulus_center(trace));
    EXPECT_LE(zone.roundness_mm, annulus + kRounding_mm) << "seed " << seed;
    EXPECT_LE(annulus, zone.roundness_mm * (1 + 2e-3)) << "seed " << seed;
    EXPECT_LT((annulus_center(trace) - zone.center_mm).norm(), 1e-3) << "seed " << seed;
  }
}

}  // namespace
}  // namespace trunnion
