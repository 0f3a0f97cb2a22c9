#include "postproc/correction.h"

#include <gmock/gmock.h>

#include <cmath>

#include "judged_machine.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kExact_mm = 1e-9;     // rounding and second order of a solver that has converged
constexpr double kExact_rad = 1e-9;    // asked of the solver
constexpr double kToolSide_mm = 2e-5;  // a tool side is corrected to first order of its errors
constexpr double kToolSide_rad = 3e-8;

struct Case {
  std::string structure;
  ToolCentrePoint tcp;
};

class CorrectorOnAnyMachine : public ::testing::TestWithParam<Case> {};

TEST_P(CorrectorOnAnyMachine, BringsTipAndAxisBackToNominal) {
  const Judged both = judged(GetParam().structure);
  const bool tool_side = both.truth.tool_axes.size() > 0;
  const TrueField field(both);
  const KinematicChain chain(both.machine);
  // Almost no damping and a wide limit: orientation is met as well.
  const CorrectionSettings settings{.tcp = GetParam().tcp,
                                    .largest_rotary_change = Angle::degrees(20),
                                    .damping = Angle::degrees(1e-5),
                                    .tool_length_mm = tool_side ? 80.0 : 0.0};
  const Corrector corrector(chain, field, settings);
  double before = 0;
  for (double a : {-90.0, -45.0, -10.0, -2.0, 20.0})
    for (double c : {-400.0, -90.0, 0.0, 37.0, 200.0}) {
      const Commanded programmed{{40, -60, 30}, {Angle::degrees(a), Angle::degrees(c)}};
      const Miss left = miss(both, programmed, corrected(corrector, programmed), settings);
      before = std::max(before, miss(both, programmed, programmed, settings).tip_mm);
      EXPECT_LT(left.tip_mm, tool_side ? kToolSide_mm : kExact_mm) << "A " << a << " C " << c;
      EXPECT_LT(left.axis_rad, tool_side ? kToolSide_rad : kExact_rad) << "A " << a << " C " << c;
    }
  EXPECT_GT(before, 0.01);
}

INSTANTIATE_TEST_SUITE_P(
    Structures, CorrectorOnAnyMachine,
    ::testing::Values(Case{"w C' A' Y' b X Z t", ToolCentrePoint::on}, Case{"w C' A' Y' b X Z t", ToolCentrePoint::off},
                      Case{"w C' B' X' b Y Z t", ToolCentrePoint::on}, Case{"w C' B' X' b Y Z t", ToolCentrePoint::off},
                      Case{"w C' X' b Y Z A t", ToolCentrePoint::on}, Case{"w C' X' b Y Z B t", ToolCentrePoint::off},
                      Case{"w X' b Y Z C A t", ToolCentrePoint::on}, Case{"w X' b Y Z C B t", ToolCentrePoint::off}));

class Seed : public ::testing::Test {
 protected:
  Judged both = judged("w C' A' Y' b X Z t");
  TrueField field{both};
  KinematicChain chain{both.machine};
};

TEST_F(Seed, DampedTiltErrorStaysSmallBeyondFiveDegrees) {
  const Corrector corrector(chain, field, {});
  for (double a = -90; a <= -5; a += 5)
    for (double c = 0; c < 360; c += 15) {
      const Commanded programmed{{30, 10, 50}, {Angle::degrees(a), Angle::degrees(c)}};
      const Miss left = miss(both, programmed, corrected(corrector, programmed), corrector.settings());
      EXPECT_LT(left.axis_rad, 8e-6) << a << " " << c;
      EXPECT_LT(left.tip_mm, kExact_mm);
    }
}

TEST_F(Seed, NearUprightThePositionIsExactAndCKeepsWithinItsLimit) {
  const TrueField large(both, 5);
  const Corrector corrector(chain, large, {});
  for (double c = 0; c < 360; c += 10) {
    double last = std::nan("");
    for (double a = -5; a <= 5; a += 0.01) {
      const Commanded programmed{{30, 10, 50}, {Angle::degrees(a), Angle::degrees(c)}};
      const RotaryCorrection turn = corrector.rotary(programmed);
      EXPECT_LE(std::abs(turn.dc.in_degrees()), 0.1);
      // Smooth: near A = 0 it goes as err sin A / lambda^2, with err < 350 urad no steeper than 1.2.
      EXPECT_FALSE(std::abs(turn.dc.in_degrees() - last) > 0.012) << a << " " << c;
      last = turn.dc.in_degrees();
    }
    const Commanded upright{{30, 10, 50}, {Angle::degrees(0), Angle::degrees(c)}};
    EXPECT_LT(std::abs(corrector.rotary(upright).dc.in_radians()), 1e-12) << c;
  }
  const Corrector usual(chain, field, {});
  for (double a : {-0.5, -0.01, 0.0, 0.3}) {
    const Commanded programmed{{30, 10, 50}, {Angle::degrees(a), Angle::degrees(70)}};
    const Commanded to = corrected(usual, programmed);
    const Miss left = miss(both, programmed, to, usual.settings());
    EXPECT_LT(left.tip_mm, kExact_mm);
    EXPECT_NEAR(left.axis_rad, usual.rotary(programmed).residual.in_radians(), 1e-9);
    EXPECT_NEAR(usual.tilt_error(programmed, to.rotary).in_radians(), left.axis_rad, 1e-9);
  }
}

TEST_F(Seed, PositionIsExactAtWhateverAnglesAreCommanded) {
  for (const ToolCentrePoint tcp : {ToolCentrePoint::on, ToolCentrePoint::off}) {
    const Corrector corrector(chain, field, {.tcp = tcp});
    const Commanded programmed{{40, -60, 30}, {Angle::degrees(-33), Angle::degrees(77)}};
    Commanded to{programmed.xyz_mm, {Angle::degrees(-33.004), Angle::degrees(77.02)}};
    to.xyz_mm += corrector.linear(programmed, to.rotary).change_mm;
    EXPECT_LT(miss(both, programmed, to, corrector.settings()).tip_mm, kExact_mm);
    EXPECT_LT(corrector.tip_error_mm(programmed, to), kExact_mm);
  }
}

TEST_F(Seed, LeavesTheRotaryAxesAloneWhenAsked) {
  const Corrector corrector(chain, field, {.orientation = Orientation::as_programmed});
  const Commanded programmed{{40, -60, 30}, {Angle::degrees(-33), Angle::degrees(77)}};
  EXPECT_EQ(corrected(corrector, programmed).rotary, programmed.rotary);
  EXPECT_LT(miss(both, programmed, corrected(corrector, programmed), corrector.settings()).tip_mm, kExact_mm);
}

TEST_F(Seed, WithoutErrorsNothingMoves) {
  const TrueField none(both, 0);
  const Corrector corrector(chain, none, {.tcp = ToolCentrePoint::off});
  const Commanded programmed{{40, -60, 30}, {Angle::degrees(-33), Angle::degrees(77)}};
  const RotaryCorrection turn = corrector.rotary(programmed);
  EXPECT_LT(std::abs(turn.da.in_radians()), 1e-15);
  EXPECT_LT(std::abs(turn.dc.in_radians()), 1e-15);
  EXPECT_LT(corrector.linear(programmed, programmed.rotary).change_mm.norm(), 1e-13);
}

}  // namespace
}  // namespace trunnion
