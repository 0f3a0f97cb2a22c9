#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "discovery/projection.h"
#include "identification/as_observations.h"
#include "identification/whitened_change.h"
#include "planning/power.h"
#include "support/probing_plan.h"
#include "support/undeclared_effects.h"

namespace trunnion {
namespace {

using testing::ProbingPlan;
using testing::VirtualMachine;

VirtualMachine sound_machine() { return testing::perfect_machine("w C' A' Y' b X Z t"); }

ObservationSet probed(const VirtualMachine& machine, const ProbingPlan& plan) {
  testing::Noise none(1);
  return testing::as_observations(probe(machine, plan, {}, none));
}

/// |P z|^2 outside free poses and the spots' offsets.
double noncentrality(const VirtualMachine& worn, const ProbingPlan& plan) {
  const Machine machine = testing::plain_machine();
  const ObservationSet without = probed(sound_machine(), plan);
  const LinearProblem problem = make_linear_problem(without, machine);
  const Eigen::VectorXd z = testing::whitened_change(problem, probed(worn, plan), without);
  const std::vector<bool> used(problem.readings.size(), true);
  const FreePoseProjection base(
      {&problem, used, Eigen::VectorXd::Zero(z.size()), {Eigen::MatrixXd(z.size(), 0), Eigen::VectorXd()}});
  return z.dot(base.apply(z).col(0));
}

/// A pose more at the end of a plan, come to in the given senses.
ProbingPlan with_pose(ProbingPlan plan, double A_deg, double C_deg, std::size_t touches, int A_dir, int C_dir) {
  const VirtualMachine machine = sound_machine();
  const double start_s = plan.touches.back().time_s;
  const int order = plan.touches.back().order + 1;
  ProbingPlan more{plan.faces, {}};
  const std::vector<std::size_t> faces = touches >= 15 ? reachable(machine, plan.faces, A_deg, C_deg)
                                                       : d_optimal(machine, plan.faces, A_deg, C_deg, touches);
  for (const std::size_t face : faces)
    more.touches.push_back({.face = face, .A_deg = A_deg, .C_deg = C_deg, .repeat = 1});
  more = timed(more, {.start_s = start_s, .first_order = order});
  for (testing::PlannedTouch& touch : more.touches) touch.A_dir = A_dir, touch.C_dir = C_dir;
  plan.touches.insert(plan.touches.end(), more.touches.begin(), more.touches.end());
  return plan;
}

constexpr int kDown = -1, kUp = 1;

TEST(NextMeasurement, ShowsABacklashOfCOnlyFromTheOtherSide) {
  VirtualMachine worn = sound_machine();
  add_rotary_backlash(worn, 'C', 8e-6);
  const ProbingPlan plan = testing::replica_plan();
  EXPECT_NEAR(noncentrality(worn, plan), 0, 1e-6);
  EXPECT_NEAR(noncentrality(worn, with_pose(plan, 0, 180, 9, kDown, kUp)), 0, 1e-6);
  EXPECT_NEAR(noncentrality(worn, with_pose(plan, 0, 180, 9, kDown, kDown)), 51, 0.5);
  EXPECT_NEAR(noncentrality(worn, with_pose(plan, -90, 180, 9, kDown, kDown)), 42,
              4);  // other nine of the fifteen spots
  ProbingPlan many = plan;
  for (const double C_deg : {60., 180., 300.}) many = with_pose(many, 0, C_deg, 9, kDown, kDown);
  EXPECT_NEAR(noncentrality(worn, many), 152, 0.5);
  for (const double C_deg : {60., 180., 300.}) many = with_pose(many, -60, C_deg, 9, kDown, kDown);
  EXPECT_NEAR(noncentrality(worn, many), 305, 0.5);
}

TEST(NextMeasurement, ShowsADriftOnlyBackWhereTheTableWasLevel) {
  const ProbingPlan plan = testing::replica_plan();
  const double whole_s = plan.touches.back().time_s;
  VirtualMachine warm = sound_machine();
  add_drift(warm, [=](double time_s) { return testing::um_urad(0, 0, 4 * time_s / whole_s, 0, 0, 0); });
  // Published for another choice of nine spots and another pace.
  EXPECT_NEAR(noncentrality(warm, plan), 0.6, 0.1);
  EXPECT_NEAR(noncentrality(warm, with_pose(plan, 0, 0, 15, kUp, kUp)), 722, 72);
  EXPECT_NEAR(noncentrality(warm, with_pose(plan, 0, 120, 9, kUp, kUp)), 534, 100);
}

TEST(NextMeasurement, TellsTwoEffectsApartAsPromised) {
  const Machine machine = testing::plain_machine();
  const std::vector<Spot> spots = column_spots();
  const ProbingPlan first = testing::replica_plan();
  const ObservationSet before = probed(sound_machine(), first);
  const std::vector<Spot> touched = spots_of(before, KinematicChain(machine));
  const PowerPlan plan =
      plan_for_power(before, machine, touched, {{"backlash:A", "backlash:C"}}, {.visits = 3, .pace = {}});
  ASSERT_EQ(plan.after.size(), 2U);
  EXPECT_TRUE(std::isinf(plan.before[0].size) || plan.before[0].size > 2 * plan.after[0].size);
  EXPECT_GT(plan.before[1].size, 2 * plan.after[1].size);
  ProbingPlan all = first;
  double time_s = first.touches.back().time_s;
  for (const Visit& visit : plan.visits)
    for (const std::size_t k : visit.spots) {
      const auto face = std::ranges::find(all.faces, touched[k].point, &testing::Face::point) - all.faces.begin();
      all.touches.push_back({.face = static_cast<std::size_t>(face),
                             .A_deg = visit.at.a.in_degrees(),
                             .C_deg = visit.at.c.in_degrees(),
                             .repeat = visit.repeat,
                             .time_s = time_s += 7,
                             .A_dir = visit.tilt_sense,
                             .C_dir = visit.turn_sense,
                             .order = all.touches.back().order + 1});
    }
  const ObservationSet without = probed(sound_machine(), all);
  const LinearProblem problem = make_linear_problem(without, machine);
  const std::vector<bool> used(problem.readings.size(), true);
  Eigen::MatrixXd z(static_cast<Eigen::Index>(problem.readings.size()), 2);
  for (const int k : {0, 1}) {
    VirtualMachine worn = sound_machine();
    add_rotary_backlash(worn, "AC"[k], plan.after[static_cast<std::size_t>(k)].size);
    z.col(k) = testing::whitened_change(problem, probed(worn, all), without);
  }
  for (const int k : {0, 1}) {  // each beside the maps and the other, whatever that is
    const SmoothProjection base(
        {&problem, used, Eigen::VectorXd::Zero(z.rows()), {z.col(1 - k), Eigen::VectorXd::Zero(1)}},
        smooth_design(problem, basis_for(problem, 3), SmoothPrior{}));
    EXPECT_NEAR(z.col(k).dot(base.apply(z.col(k)).col(0)), 25.6, 0.3) << "AC"[k];
  }
}

TEST(NextMeasurement, KeepsToTheTime) {
  const Machine machine = testing::plain_machine();
  const ObservationSet before = probed(sound_machine(), testing::replica_plan());
  const std::vector<Spot> spots = spots_of(before, KinematicChain(machine));
  PowerOptions options{.visits = 6, .most_s = 200, .pace = {}};
  const PowerPlan plan = plan_for_power(before, machine, spots, {{"backlash:C"}}, options);
  ASSERT_FALSE(plan.visits.empty());
  EXPECT_LT(plan.visits.size(), 6U);
  const ObservationSet set = planned_observations(machine, spots, plan.visits, {}, "plan");
  EXPECT_LE(set.rows.back().time_s, options.most_s);
  options.most_s = 5;
  EXPECT_TRUE(plan_for_power(before, machine, spots, {{"backlash:C"}}, options).visits.empty());
}

}  // namespace
}  // namespace trunnion
