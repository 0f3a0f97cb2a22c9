#include "errormap/cross_validation.h"

#include <gtest/gtest.h>

#include "errormap/fields.h"

namespace trunnion {
namespace {

const std::vector<Angle> kLeftOutA = stations_deg({-90, -60, -30, -10, 0});

/// One harmonic, linear in the tilt: what is left of the grid still tells it.
RotaryErrors simple(IndexedPosition at) {
  RotaryErrors e;
  e.tilt.rotation_rad = {1e-5 * at.a.in_radians(), 0, 0};
  e.turn.translation_mm = {0.01 * std::cos(at.c.in_radians()), 0.01 * at.a.in_radians() * std::sin(at.c.in_radians()),
                           0};
  return e;
}

TEST(CrossValidation, FindsNothingWhereTheRestOfTheGridTellsAll) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  const ErrorGrid grid = sampled(simple, kLeftOutA, stations_deg({0, 60, 120, 180, 240, 300}));
  const CrossValidation found = cross_validate(Interpolation::trig_cubic, grid, chain);
  EXPECT_EQ(found.columns.nodes, 30U);
  EXPECT_EQ(found.rows.nodes, 18U);
  EXPECT_EQ(found.all.nodes, 48U);
  EXPECT_LT(found.all.displacement.in_micrometres(), 1e-10);
  EXPECT_LT(found.all.rotation.in_microradians(), 1e-10);
}

TEST(CrossValidation, TellsWhatAnInterpolantMissesInNumbers) {
  // Bilinear, a column left out of six: its neighbours stand 60 deg away, their mean is cos 60 of the value, so that
  // half of the amplitude is missed: 10 um (1 - 1/2) cos c, over a turn 10 / 2 / sqrt 2.
  const auto radial = [](IndexedPosition at) {
    RotaryErrors e;
    e.turn.translation_mm = {0.01 * std::cos(at.c.in_radians()), 0, 0};
    e.turn.rotation_rad = {0, 0, 2e-5 * std::cos(at.c.in_radians())};
    return e;
  };
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  const ErrorGrid grid = sampled(radial, kLeftOutA, stations_deg({0, 60, 120, 180, 240, 300}));
  const CrossValidation found = cross_validate(Interpolation::bilinear, grid, chain);
  EXPECT_NEAR(found.columns.displacement.in_micrometres(), 5 / std::sqrt(2.), 1e-10);
  EXPECT_NEAR(found.columns.rotation.in_microradians(), 10 / std::sqrt(2.), 1e-10);
  EXPECT_LT(found.rows.displacement.in_micrometres(), 1e-10);
}

TEST(CrossValidation, LeavesNothingOutOfAGridThatIsTooSmall) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  const ErrorGrid grid = sampled(simple, stations_deg({-90, 0}), stations_deg({0, 180}));
  EXPECT_EQ(cross_validate(Interpolation::trig_cubic, grid, chain).all.nodes, 0U);
}

}  // namespace
}  // namespace trunnion
