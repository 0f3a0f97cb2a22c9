#include <gmock/gmock.h>

#include "compensation/axis_correction.h"
#include "compensation/number_text.h"
#include "compensation/piecewise_linear.h"
#include "compensation/profile.h"
#include "compensation/projection.h"
#include "error.h"
#include "sample_models.h"
#include "support/noise.h"

namespace trunnion {
namespace {

using compensation_test::random_model;
using compensation_test::trunnion_machine;

/// A table of one's own choice.
class Fixed : public PlayedCompensation {
 public:
  explicit Fixed(AxisCorrection correction) : correction_(std::move(correction)) {}
  AxisCorrection at(const Situation&) const override { return correction_; }

 private:
  AxisCorrection correction_;
};

TEST(RemainingDeviation, IsTheDeviationWhereNothingIsCorrected) {
  const Machine machine = trunnion_machine();
  const Model model = random_model(machine, 1);
  for (const Situation& s : pose_sample(working_volume(machine, model), model, 50, 0)) {
    const Remaining left = remaining(model, KinematicChain(machine), s, {});
    EXPECT_LT((left.position_mm - deviation_mm(model, s)).norm(), 1e-12);
  }
}

TEST(RemainingDeviation, FollowsWhatTheAxesDo) {
  // No errors: at A -90, C 0 the table's X, Z point (0, 50, 20) of R. A by +1e-4 rad moves the work by ex x p, C by
  // Rx(A) ez x p.
  const Machine machine = trunnion_machine();
  Situation s;
  s.at.a = Angle::degrees(-90);
  s.point_r_mm = {10, 50, 20};
  const KinematicChain chain(machine);
  constexpr double kSecondOrder_mm = 1e-6;
  EXPECT_LT(
      (remaining({}, chain, s, {.linear_mm = {0.1, -0.2, 0.3}}).position_mm - Eigen::Vector3d(-0.1, 0.2, -0.3)).norm(),
      1e-12);
  EXPECT_LT((remaining({}, chain, s, {.tilt_rad = 1e-4}).position_mm - Eigen::Vector3d(0, -2e-3, 5e-3)).norm(),
            kSecondOrder_mm);
  EXPECT_LT((remaining({}, chain, s, {.turn_rad = 1e-4}).position_mm - Eigen::Vector3d(2e-3, 0, -1e-3)).norm(),
            kSecondOrder_mm);
  EXPECT_NEAR(remaining({}, chain, s, {.tilt_rad = 1e-4}).tilt_rad, 1e-4, 1e-9);
  EXPECT_NEAR(remaining({}, chain, s, {.turn_rad = 1e-4}).tilt_rad, 1e-4, 1e-9);
  s.at.a = Angle();
  EXPECT_NEAR(remaining({}, chain, s, {.turn_rad = 1e-4}).tilt_rad, 0, 1e-12) << "C turns about the tool";
}

TEST(IdealCorrection, PutsTheTipWhereItShouldBeOnAllStructures) {
  for (const char* code : {"w C' A' Y' b X Z t", "w C' B' Y' b X Z t", "w C' X' b Y Z B t", "w X' b Y Z C A t"}) {
    Machine machine = trunnion_machine();
    machine.structure = parse_structure(code);
    machine.axes = default_axes(machine.structure);
    const Model model = compensation_test::model_of(testing::smooth_machine(3, {}, "w C' A' Y' b X Z t"), machine);
    const KinematicChain chain(machine);
    machine.work_volume.a = Range<Angle>{Angle::degrees(-90), Angle::degrees(-20)};
    WorkingVolume volume = working_volume(machine, model);
    volume.tool_length = Length::millimetres(100);
    for (const Situation& s : pose_sample(volume, model, 40, 0)) {
      const Remaining left = remaining(model, chain, s, ideal_correction(model, chain, machine.limits, s));
      EXPECT_LT(left.position_mm.norm(), 1e-9) << code;
      EXPECT_LT(left.tilt_rad, 0.5e-6) << code << " A " << s.at.a.in_degrees();
    }
  }
}

TEST(PiecewiseLinear, FindsThePolygonItWasSampledFrom) {
  const PiecewiseLinear function({0, 1, 3, 4}, Boundary::hold);
  const std::vector<double> at = function.sample_points(3);
  Eigen::VectorXd y(static_cast<Eigen::Index>(at.size()));
  for (std::size_t s = 0; s < at.size(); ++s)
    y[static_cast<Eigen::Index>(s)] = at[s] < 1 ? at[s] : (at[s] < 3 ? 1 - (at[s] - 1) : -1 + 5 * (at[s] - 3));
  EXPECT_TRUE((function.projector(at) * y).isApprox(Eigen::Vector4d(0, 1, -1, 4), 1e-12));
}

TEST(PiecewiseLinear, LosesLessThanItsValuesAtTheNodesAndRepeats) {
  const PiecewiseLinear function(even_nodes(0, 360, 30), Boundary::repeat);
  const std::vector<double> at = function.sample_points(9);
  Eigen::VectorXd y(static_cast<Eigen::Index>(at.size()));
  for (std::size_t s = 0; s < at.size(); ++s) y[static_cast<Eigen::Index>(s)] = std::cos(at[s] * M_PI / 180);
  const Eigen::VectorXd nodes = function.projector(at) * y;
  EXPECT_EQ(nodes[0], nodes[12]);
  EXPECT_GT(nodes[0], 1.005) << "the chord cuts the arc on both sides";
}

TEST(VolumeMetric, IsTheMeanSquareOverTheVolume) {
  const Machine machine = trunnion_machine();
  const Model model = random_model(machine, 2);
  WorkingVolume volume = working_volume(machine, model);
  volume.x = {Length::millimetres(-50), Length::millimetres(200)};
  Vector6d t;
  t << 1e-3, -2e-3, 3e-3, 20e-6, -30e-6, 10e-6;
  constexpr double kHaltonShare = 1e-3;  // of a mean over 20000 points
  double sum = 0;
  const auto sample = pose_sample(volume, model, 20000, 0);
  for (const Situation& s : sample) sum += (displacement_jacobian(s.point_r_mm) * t).squaredNorm();
  const double tilt = 400 * (t[3] * t[3] + t[4] * t[4]);
  EXPECT_NEAR(t.dot(volume_metric(volume) * t) - tilt, sum / static_cast<double>(sample.size()),
              kHaltonShare * sum / 20000);
}

TEST(Profile, AnswersAreTakenAndConfirmedOneByOne) {
  Machine machine = trunnion_machine();
  const ProfileQuestions questions{{{"cec_sign", "?", {"add", "subtract"}, "!"}, {"order", "?", {"ij", "ji"}, "!"}},
                                   {{"tables", "number of tables", 8, 0, 100}}};
  EXPECT_EQ(Profile(machine, questions).unconfirmed().size(), 2U);
  machine.profile["cec_sign"] = std::string("subtract confirmed");
  machine.profile["order"] = std::string("confirmed");
  machine.profile["tables"] = 62.0;
  const Profile profile(machine, questions);
  EXPECT_TRUE(profile.load_ready());
  EXPECT_EQ(profile.answer("cec_sign"), "subtract");
  EXPECT_EQ(profile.answer("order"), "ij");
  EXPECT_EQ(profile.number("tables"), 62);
  machine.profile["cec_sign"] = std::string("subtract");
  EXPECT_FALSE(Profile(machine, questions).load_ready());
}

TEST(Profile, AWrongAnswerIsNamed) {
  Machine machine = trunnion_machine();
  const ProfileQuestions questions{{{"cec_sign", "?", {"add", "subtract"}, "!"}}, {{"tables", "n", 8, 0, 100}}};
  machine.profile["cec_sign"] = std::string("plus");
  try {
    const Profile profile(machine, questions);
    FAIL();
  } catch (const ModelError& error) {
    EXPECT_STREQ(
        error.what(),
        "profile.cec_sign: \"plus\" found, one of \"add\", \"subtract\" is wanted, followed by \" confirmed\" once it "
        "was seen on the machine");
  }
  machine.profile = {{"tables", 101.0}};
  try {
    const Profile profile(machine, questions);
    FAIL();
  } catch (const ModelError& error) {
    EXPECT_STREQ(error.what(), "profile.tables: 101 found, a number from 0 to 100 is wanted");
  }
}

TEST(WorkingVolume, ATiltThatWasNotProbedIsRefused) {
  Machine machine = trunnion_machine();
  const Model model = random_model(machine, 4);
  machine.work_volume.a = Range<Angle>{Angle::degrees(-100), Angle::degrees(0)};
  try {
    working_volume(machine, model);
    FAIL();
  } catch (const RangeError& error) {
    EXPECT_STREQ(error.what(), "work_volume.A_deg: -100 to 0 asked for, the model was probed from -90 to 0");
  }
}

TEST(WorkingVolume, DefaultsAreTheProbedTiltAFullTurnAndACubeCutToTheStrokes) {
  Machine machine = trunnion_machine();
  machine.work_volume.a.reset();
  machine.axes.at('Z').range_length = Range<Length>{Length::millimetres(-40), Length::millimetres(500)};
  const WorkingVolume volume = working_volume(machine, random_model(machine, 4));
  EXPECT_NEAR(volume.a.low.in_degrees(), -90, 1e-9);
  EXPECT_NEAR(volume.c.high.in_degrees(), 360, 1e-9);
  EXPECT_EQ(volume.z.low.in_millimetres(), -40);
  EXPECT_EQ(volume.x.high.in_millimetres(), 150);
}

TEST(NumberText, NeverSaysMinusZeroAndReadsBack) {
  EXPECT_EQ(fixed_text(-0.00001, 4), "0.0000");
  EXPECT_EQ(fixed_text(-0.00005001, 4), "-0.0001");
  EXPECT_EQ(shortest_text(-0.0), "0");
  EXPECT_EQ(number_from("+1.5"), 1.5);
  for (const char* wrong : {"", "1.5x", "+-1", "nan", "inf", "1e999"}) EXPECT_FALSE(number_from(wrong)) << wrong;
}

}  // namespace
}  // namespace trunnion
