#include <gtest/gtest.h>

#include <cmath>

#include "identification/as_observations.h"
#include "identification/identify.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"

namespace trunnion {
namespace {

/// Root mean square error of the deviation over the working volume at positions off the grid, mm.
double map_error_mm(const Model& model, const testing::VirtualMachine& machine) {
  testing::Noise places(99);
  double sum = 0, count = 0;
  for (int k = 0; k < 120; ++k) {
    const double a = -90 * places.uniform(), c = 360 * places.uniform();
    for (const double x : {-100.0, 100.0})
      for (const double y : {-100.0, 100.0})
        for (const double z : {0.0, 100.0}) {
          Situation s;
          s.at = {Angle::degrees(a), Angle::degrees(c)};
          s.point_r_mm = {x, y, z};
          testing::MachineState state;
          state.rotary = testing::ac_degrees(a, c);
          state.tip_r_mm = s.point_r_mm;
          sum += (deviation_mm(model, s) - machine.deviation_mm(state)).squaredNorm();
          ++count;
        }
  }
  return std::sqrt(sum / count);
}

TEST(IdentificationSweep, BetweenTheNodesIsBetterThanTwoStepsAndBilinear) {
  // Twenty smooth machines with two harmonics in C: the error between the nodes against the usual way.
  double worst = 0, sum = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const testing::VirtualMachine machine = testing::smooth_machine(100 + seed);
    testing::Noise noise(7 + seed);
    testing::ProbingPlan plan = testing::replica_plan();
    plan.faces = testing::as_built(plan.faces, noise, 20e-3, 50e-6);
    const ObservationSet set = testing::as_observations(testing::probe(machine, plan, {.sigma_mm = 0.175e-3}, noise));
    const double usual = map_error_mm(
        identify(set, testing::plain_machine(), {.method = IdentificationMethod::two_step}).model, machine);
    const double ours = map_error_mm(identify(set, testing::plain_machine()).model, machine);
    worst = std::max(worst, ours / usual);
    sum += ours / usual;
    EXPECT_LT(ours / usual, 0.40) << "seed " << seed;
  }
  RecordProperty("worst_ratio", std::to_string(worst));
  std::printf("map error between the nodes over the usual way: worst %.3f, mean %.3f of 20 machines\n", worst,
              sum / 20);
}

}  // namespace
}  // namespace trunnion
