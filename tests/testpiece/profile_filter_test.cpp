#include "testpiece/profile_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "error.h"
#include "units/angle.h"

namespace trunnion {
namespace {

RoundnessTrace wave(int k, std::size_t points = 720) {
  RoundnessTrace trace{.nominal_radius_mm = 40};
  for (std::size_t i = 0; i < points; ++i) {
    trace.phi_rad.push_back(kTurn_rad * static_cast<double>(i) / static_cast<double>(points));
    trace.radial_mm.push_back(std::cos(k * trace.phi_rad.back() - 0.7));
  }
  return trace;
}

TEST(ProfileFilter, PassesHalfOfTheUndulationAtTheCutoff) {
  for (const int cutoff : {15, 50}) {
    const RoundnessTrace filtered = gaussian_filtered(wave(cutoff), cutoff);
    EXPECT_NEAR(undulations(filtered, cutoff).back().amplitude_mm, 0.5, 1e-9);
    EXPECT_NEAR(undulations(filtered, cutoff).back().phase_rad, 0.7, 1e-9);
  }
}

TEST(ProfileFilter, TransmissionIsTheStandardsGaussian) {
  for (const int k : {0, 1, 2, 5, 10, 20, 30}) {
    const double expected = std::exp(-std::numbers::ln2 * k * k / 225.0);  // pi alpha^2 = ln 2
    const std::vector<Undulation> found = undulations(gaussian_filtered(wave(k), 15), 30);
    EXPECT_NEAR(found[static_cast<std::size_t>(k)].amplitude_mm, k == 0 ? std::cos(0.7) : expected, 1e-9) << k;
  }
}

TEST(ProfileFilter, AConstantPassesUnevenSpacingUnchanged) {
  RoundnessTrace trace{.nominal_radius_mm = 1};
  for (int i = 0; i < 50; ++i) trace.phi_rad.push_back(0.001 * i * i + 0.07 * i), trace.radial_mm.push_back(3);
  for (const double r : gaussian_filtered(trace, 15).radial_mm) EXPECT_NEAR(r, 3, 1e-12);
}

TEST(ProfileFilter, RefusesACutoffThatIsNone) { EXPECT_THROW(gaussian_filtered(wave(1), 0), UsageError); }

TEST(Undulations, GiveBackAmplitudeAndPhase) {
  const std::vector<Undulation> found = undulations(wave(4, 36), 8);
  ASSERT_EQ(found.size(), 9U);
  for (const Undulation& u : found) EXPECT_NEAR(u.amplitude_mm, u.per_turn == 4 ? 1 : 0, 1e-12) << u.per_turn;
  EXPECT_NEAR(found[4].phase_rad, 0.7, 1e-12);
}

}  // namespace
}  // namespace trunnion
