#include <gmock/gmock.h>

#include <cmath>

#include "discovery/workbench.h"
#include "error.h"
#include "identification/as_observations.h"
#include "identification/whitened_change.h"
#include "io/observation_file.h"
#include "io/probe_program.h"
#include "planning/power.h"
#include "support/probing_plan.h"
#include "support/undeclared_effects.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;

Machine the_machine() {
  Machine machine = testing::plain_machine();
  machine.axes.at('A').range_angle = Range<Angle>{Angle::degrees(-110), Angle::degrees(30)};
  return machine;
}

/// One pass upwards in C, as a first measurement often is.
ObservationSet one_pass(const Machine& machine, const std::vector<Spot>& spots) {
  std::vector<Visit> visits;
  const KinematicChain chain(machine);
  for (const double a : {0., -30., -60., -90.})
    for (const double c : {0., 60., 120., 180., 240., 300.}) {
      const IndexedPosition at{Angle::degrees(a), Angle::degrees(c)};
      visits.push_back(
          {.at = at,
           .spots = a == 0 && c == 0 ? reachable(machine, chain, spots, at) : best_spots(machine, chain, spots, at, 12),
           .tilt_sense = -1});
    }
  return planned_observations(machine, spots, visits, {}, "one pass");
}

/// The same touches on a machine that really has the effect.
ObservationSet touched(const ObservationSet& plan, const std::vector<Spot>& spots,
                       const testing::VirtualMachine& machine) {
  testing::ProbingPlan rows;
  for (const Spot& spot : spots)
    rows.faces.push_back({spot.point, spot.artifact, spot.place_w_mm, spot.outward_w, spot.place_w_mm, spot.outward_w});
  for (const Observation& o : plan.rows) {
    const auto face = std::ranges::find(spots, plan.points[o.point], &Spot::point) - spots.begin();
    rows.touches.push_back({.face = static_cast<std::size_t>(face),
                            .A_deg = o.at.a.in_degrees(),
                            .C_deg = o.at.c.in_degrees(),
                            .repeat = o.repeat,
                            .time_s = o.time_s,
                            .A_dir = o.tilt_sense,
                            .C_dir = o.turn_sense,
                            .order = static_cast<int>(rows.touches.size())});
  }
  testing::Noise none(1);
  return testing::as_observations(probe(machine, rows, {}, none));
}

TEST(FirstPlan, KeepsTheProbeOffTheOtherColumns) {
  const Machine machine = the_machine();
  const KinematicChain chain(machine);
  const std::vector<Spot> spots = column_spots();
  const auto named = [&](const char* point) {
    return static_cast<std::size_t>(std::ranges::find(spots, point, &Spot::point) - spots.begin());
  };
  // With the table upright, the first column stands over the third.
  const std::vector<std::size_t> upright = reachable(machine, chain, spots, {Angle::degrees(-90), Angle()});
  EXPECT_EQ(std::ranges::count(upright, named("3S4")), 0);
  EXPECT_EQ(std::ranges::count(upright, named("1S4")), 1);
  EXPECT_EQ(std::ranges::count(upright, named("2S4")), 1);
  EXPECT_EQ(reachable(machine, chain, spots, {}).size(), spots.size());
  // Point by point along the stylus, from the ball at a face and from where it starts: no column is met.
  const double radius_mm = machine.probe.ball_radius.in_millimetres();
  std::size_t touches = 0;
  for (const Visit& visit : first_plan(machine, spots, {})) {
    const Eigen::Isometry3d r_from_w = chain.r_from_w(visit.at), w_from_r = r_from_w.inverse();
    EXPECT_GE(visit.spots.size(), 6U) << visit.at.a.in_degrees() << " " << visit.at.c.in_degrees();
    for (const std::size_t k : visit.spots) {
      ++touches;
      const Eigen::Vector3d outward = r_from_w.linear() * spots[k].outward_w;
      for (const double off : {radius_mm + 0.01, radius_mm + kLargestStandoff_mm})
        for (double up = 0; up < 400; up += 1) {
          const Eigen::Vector3d p =
              w_from_r * (r_from_w * spots[k].place_w_mm + off * outward + Eigen::Vector3d(0, 0, up));
          for (const Eigen::Vector2d& centre : {Eigen::Vector2d(-90, -90), {90, -90}, {-90, 90}}) {
            const Eigen::Vector2d across = (p.head<2>() - centre).cwiseAbs();
            const bool own = spots[k].artifact == (centre.x() > 0 ? "2" : centre.y() > 0 ? "3" : "1");
            const double reach = own ? 0 : radius_mm;
            EXPECT_FALSE(across.maxCoeff() < 20 + reach && p.z() < 110 + reach && p.z() > 0)
                << spots[k].point << " at A " << visit.at.a.in_degrees() << " C " << visit.at.c.in_degrees();
          }
        }
    }
  }
  EXPECT_GT(touches, 500U);
}

TEST(FirstPlan, HasWhatTellsDriftAndBacklashFromTheMaps) {
  const Machine machine = the_machine();
  const KinematicChain chain(machine);
  const std::vector<Spot> spots = column_spots();
  ASSERT_EQ(spots.size(), 18U);
  const std::vector<Visit> plan = first_plan(machine, spots, {});
  std::size_t references = 0, off_grid = 0;
  for (const Visit& v : plan) {
    const bool reference = v.at.a == Angle() && v.at.c == Angle();
    references += reference ? 1 : 0;
    if (reference) {
      EXPECT_EQ(v.spots.size(), 18U);
    }
    off_grid += std::abs(std::remainder(v.at.c.in_degrees(), 60)) > 1 ? 1 : 0;
    for (const std::size_t k : v.spots)  // never from below
      EXPECT_GT((chain.r_from_w(v.at).linear() * spots[k].outward_w).z(), -0.06);
    EXPECT_LE(v.at.a, Angle());
    EXPECT_GE(v.at.a, Angle::degrees(-90) - Angle::degrees(1e-9));
  }
  EXPECT_EQ(references, 3U);
  EXPECT_TRUE(plan.front().at.c == Angle() && plan.back().at.c == Angle());
  EXPECT_GE(off_grid, 4U);
  // Every position of the grid is come to from both sides in C.
  const ObservationSet set = planned_observations(machine, spots, plan, {}, "plan");
  int both = 0, all = 0;
  for (const PoseGroup& pose : pose_groups(set)) {
    if (pose.reference || std::abs(std::remainder(pose.at.c.in_degrees(), 60)) > 1) continue;
    bool up = false, down = false;
    for (const std::size_t r : pose.rows) (set.rows[r].turn_sense > 0 ? up : down) = true;
    ++all, both += up && down ? 1 : 0;
  }
  EXPECT_EQ(all, 23);
  EXPECT_EQ(both, all);
  EXPECT_NO_THROW(make_linear_problem(set, machine));
}

TEST(FirstPlan, KeepsWithinStrokes) {
  Machine machine = the_machine();
  machine.axes.at('A').range_angle = Range<Angle>{Angle::degrees(-45), Angle::degrees(45)};
  machine.axes.at('X').range_length = Range<Length>{Length::millimetres(-120), Length::millimetres(150)};
  const std::vector<Spot> spots = column_spots();
  const ObservationSet set = planned_observations(machine, spots, first_plan(machine, spots, {}), {}, "plan");
  for (const Observation& o : set.rows) {
    EXPECT_GE(o.at.a, Angle::degrees(-45.001));
    EXPECT_GE(o.position_mm.x(), -120);
    EXPECT_LE(o.position_mm.x(), 150);
  }
}

TEST(PlanForPower, PromisesWhatAMachineWithThatMuchBacklashShows) {
  const Machine machine = the_machine();
  const std::vector<Spot> spots = column_spots();
  const ObservationSet before = one_pass(machine, spots);
  for (const char axis : {'A', 'C'}) {
    const PowerPlan plan =
        plan_for_power(before, machine, spots, {{std::string("backlash:") + axis}}, {.visits = 3, .pace = {}});
    ASSERT_EQ(plan.after.size(), 1U);
    EXPECT_LT(plan.after[0].size, 0.5 * plan.before[0].size);
    PlanOptions later;
    later.start_s = before.rows.back().time_s;
    const ObservationSet all = joined(before, planned_observations(machine, spots, plan.visits, later, "next"));
    testing::VirtualMachine sound = testing::perfect_machine("w C' A' Y' b X Z t"), worn = sound;
    add_rotary_backlash(worn, axis, plan.after[0].size);
    const ObservationSet with = touched(all, spots, worn), without = touched(all, spots, sound);
    // The noncentrality of that much, in a smooth map's eyes.
    const LinearProblem problem = make_linear_problem(without, machine);
    const Eigen::VectorXd z = testing::whitened_change(problem, with, without);
    const std::vector<bool> used(problem.readings.size(), true);
    const SmoothProjection base(
        {&problem, used, Eigen::VectorXd::Zero(z.size()), {Eigen::MatrixXd(z.size(), 0), Eigen::VectorXd()}},
        smooth_design(problem, basis_for(problem, 3), SmoothPrior{}));
    EXPECT_NEAR(z.dot(base.apply(z).col(0)), 25.6, 0.3) << axis;
  }
}

TEST(PlanForPower, ComesBackFromTheOtherSideForABacklash) {
  const Machine machine = the_machine();
  const std::vector<Spot> spots = column_spots();
  const ObservationSet before = one_pass(machine, spots);  // A only downwards: its backlash is invisible
  const PowerPlan plan = plan_for_power(before, machine, spots, {{"backlash:A"}}, {.visits = 1, .pace = {}});
  EXPECT_GT(plan.before[0].size, 1e-3);
  EXPECT_LT(plan.after[0].size, 20e-6);
  EXPECT_EQ(plan.visits[0].tilt_sense, 1);
  EXPECT_THAT([&] { plan_for_power(before, machine, spots, {{"payload_sag"}}, {.visits = 1, .pace = {}}); },
              ::testing::ThrowsMessage<UsageError>(HasSubstr("with and without load")));
  EXPECT_THROW(plan_for_power(before, machine, spots, {{"gremlins"}}, {.visits = 1, .pace = {}}), ModelError);
}

TEST(ProbeProgram, ItsLogReadsBackAsThePlan) {
  const Machine machine = the_machine();
  const std::vector<Spot> spots = column_spots();
  const ObservationSet plan = planned_observations(machine, spots, first_plan(machine, spots, {}), {}, "plan");
  const std::string program = linuxcnc_probe_program(plan, machine, {}, "touches.log");
  EXPECT_THAT(program, HasSubstr("(LOGOPEN,touches.log)"));
  // A control that meets every face where it nominally is: the ball's centre stands a radius before it.
  std::string log;
  std::size_t touch = 0, at = 0;
  double z_mm = 0;
  bool turned_low = false;
  for (std::size_t end; (end = program.find('\n', at)) != std::string::npos; at = end + 1) {
    std::string block = program.substr(at, end - at);
    if (block.starts_with("G0 Z")) z_mm = std::stod(block.substr(4));
    if (block.starts_with("G0 A") && z_mm < 200) turned_low = true;
    if (!block.starts_with("(LOG,")) continue;
    block = block.substr(5, block.size() - 6);
    if (const std::size_t mark = block.find("#5061"); mark != std::string::npos) {
      const Observation& o = plan.rows[touch++];
      const Eigen::Vector3d centre = o.position_mm - machine.probe.ball_radius.in_millimetres() * o.direction;
      char numbers[100];
      std::snprintf(numbers, sizeof numbers, "%.6f,%.6f,%.6f", centre.x(), centre.y(), centre.z());
      block.replace(mark, std::string::npos, numbers);
    }
    log += block + "\n";
  }
  EXPECT_EQ(touch, plan.rows.size());
  EXPECT_FALSE(turned_low) << "a rotary axis moves while the probe is down";
  const ObservationSet read = parse_probe_log(log, "touches.log", machine);
  ASSERT_EQ(read.rows.size(), plan.rows.size());
  for (std::size_t r = 0; r < plan.rows.size(); ++r) {
    const Observation &a = plan.rows[r], &b = read.rows[r];
    EXPECT_LT((a.position_mm - b.position_mm).norm(), 2e-6);
    EXPECT_EQ(plan.points[a.point], read.points[b.point]);
    EXPECT_EQ(plan.artifacts[a.artifact], read.artifacts[b.artifact]);
    EXPECT_TRUE(a.tilt_sense == b.tilt_sense && a.turn_sense == b.turn_sense && a.repeat == b.repeat);
    EXPECT_NEAR(a.at.a.in_degrees(), b.at.a.in_degrees(), 1e-5);
  }
  // And as an observations file.
  const ObservationSet file = parse_observations(observations_text(read, 'A'), "o.csv", machine);
  EXPECT_EQ(file.rows.size(), read.rows.size());
}

TEST(ProbeProgram, RefusesAHeadThatTurnsTheProbe) {
  const Machine head = testing::plain_machine("w C' b X Y Z A t");
  const std::vector<Spot> spots = column_spots();
  const ObservationSet plan = planned_observations(head, spots, first_plan(head, spots, {}), {}, "plan");
  EXPECT_THAT([&] { linuxcnc_probe_program(plan, head, {}, "t.log"); },
              ::testing::ThrowsMessage<RefusalError>(HasSubstr("carries the tool")));
}

TEST(ProbeLog, SaysWhatIsWrongInOneLine) {
  const Machine machine = the_machine();
  const std::string head = "trunnion-probe-log,1,virtual,0\n";
  const auto wrong = [&](const std::string& text, const std::string& said) {
    EXPECT_THAT([&] { parse_probe_log(text, "t.log", machine); },
                ::testing::Throws<Error>(::testing::Property(&Error::what, HasSubstr(said))));
  };
  wrong("", "no touch in it");
  wrong(head, "no touch in it");
  wrong("touch,1S1", "t.log:1: the log begins with");
  wrong("trunnion-probe-log,2,virtual,0\n", "t.log:1: trunnion-probe-log,1,MACHINE,SERIAL is wanted");
  wrong("trunnion-probe-log,1,virtual,7\n", "probed on serial 7");
  wrong(head + "touch,1S1,1,0\n", "t.log:2: touch and 15 fields are wanted, 4 found");
  wrong(head + "touch,1S1,1,0,x,1,1,0,1,1,0,0,3,1,2,3\n", "t.log:2: field 5: \"x\" found");
  wrong(head + "touch,1S1,1,0,0,2,1,0,1,1,0,0,3,1,2,3\n", "field 6: a sense of motion");
  wrong(head + "touch,1S1,1,0,0,1,1,-1,1,1,0,0,3,1,2,3\n", "field 8");
  wrong(head + "touch,1S1,1,0,0,1,1,0,1,1,1,0,3,1,2,3\n", "fields 10 to 12: a unit vector");
}

}  // namespace
}  // namespace trunnion
