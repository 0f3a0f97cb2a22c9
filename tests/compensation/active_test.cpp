#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compensation/bare_readings.h"
#include "compensation/verification.h"
#include "identification/as_observations.h"
#include "identification/identify.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"

// A machine is calibrated, its compensation loaded; it changes, is measured with the compensation switched on, and gets
// a new compensation. The machine and its control are simulated exactly, by code of the tests alone.

namespace trunnion {
namespace {

using testing::VirtualMachine;

constexpr double kSigma_mm = 0.175e-3;

Machine the_machine(const std::string& controller) {
  Machine machine = testing::plain_machine();
  machine.controller = controller;
  machine.axes.at('A').range_angle = Range<Angle>{Angle::degrees(-120), Angle::degrees(30)};
  machine.work_volume.a = Range<Angle>{Angle::degrees(-90), Angle::degrees(0)};
  return machine;
}

Situation commanded(double A_deg, double C_deg, const Eigen::Vector3d& p) {
  Situation s;
  s.at = {Angle::degrees(A_deg), Angle::degrees(C_deg)};
  s.point_r_mm = p;
  return s;
}

/// Probing under a compensation: the machine goes to p + c at A + dA, C + dC and the control shows p.
std::vector<testing::ObservationRow> probed(const VirtualMachine& machine, testing::ProbingPlan plan,
                                            const PlayedCompensation* played, std::uint64_t seed) {
  std::vector<testing::PlannedTouch> shown = plan.touches;
  const KinematicChain chain(testing::plain_machine());
  std::vector<Eigen::Vector3d> added(plan.touches.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; played != nullptr && i < plan.touches.size(); ++i) {
    testing::PlannedTouch& touch = plan.touches[i];
    const IndexedPosition at{Angle::degrees(touch.A_deg), Angle::degrees(touch.C_deg)};
    const Eigen::Vector3d face = chain.r_from_w(at) * plan.faces[touch.face].nominal_w_mm;
    const AxisCorrection c = played->at(commanded(touch.A_deg, touch.C_deg, face));
    touch.A_deg += Angle::radians(c.tilt_rad).in_degrees();
    touch.C_deg += Angle::radians(c.turn_rad).in_degrees();
    added[i] = c.linear_mm;
  }
  testing::Noise noise(seed);
  std::vector<testing::ObservationRow> rows = testing::probe(machine, plan, {.sigma_mm = kSigma_mm}, noise);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].A_deg = shown[i].A_deg;
    rows[i].C_deg = shown[i].C_deg;
    *rows[i].xyz_mm -= added[i];
  }
  return rows;
}

/// Root mean square distance between workpiece and tool that the compensated machine really has, um.
double remaining_um(const VirtualMachine& machine, const PlayedCompensation* played) {
  const KinematicChain chain(testing::plain_machine());
  testing::Noise places(5);
  double sum = 0;
  constexpr int kPlaces = 300;
  for (int k = 0; k < kPlaces; ++k) {
    const double A_deg = places.uniform(-90, 0), C_deg = places.uniform(0, 360);
    const Eigen::Vector3d p(places.uniform(-100, 100), places.uniform(-100, 100), places.uniform(40, 110));
    const Situation s = commanded(A_deg, C_deg, p);
    const AxisCorrection c = played != nullptr ? played->at(s) : AxisCorrection{};
    const IndexedPosition there{s.at.a + Angle::radians(c.tilt_rad), s.at.c + Angle::radians(c.turn_rad)};
    testing::MachineState state;
    state.rotary = testing::ac_degrees(there.a.in_degrees(), there.c.in_degrees());
    state.tip_r_mm = chain.r_from_w(there) * (chain.r_from_w(s.at).inverse() * p);  // where the point nominally is now
    sum += (state.tip_r_mm + machine.deviation_mm(state) - p - c.linear_mm).squaredNorm();
  }
  return 1e3 * std::sqrt(sum / kPlaces);
}

std::unique_ptr<PlayedCompensation> loaded(const std::string& how, const Machine& machine, const Model& model) {
  if (how == "model") return std::make_unique<PlayedModel>(model, KinematicChain(machine), machine.limits);
  return play_tables(make_tables(controller_named(how), machine, model, {}).files, machine, model);
}

/// What is switched on, the share of the bare machine's error that it may leave, how often that is what the old tables
/// leave if they are forgotten, and a crash that it can make good.
struct SwitchedOn {
  const char* name;
  double share_left = 0.2, worse_forgotten = 3;
  double crash_mm = 12e-3, crash_rad = 60e-6;
};

class Active : public ::testing::TestWithParam<SwitchedOn> {};

TEST_P(Active, ALoopOfCompensationsConverges) {
  const auto& [name, share_left, worse_forgotten, crash_mm, crash_rad] = GetParam();
  const std::string how = name;
  const Machine machine = the_machine(how == "model" ? "linuxcnc" : how);
  const KinematicChain chain(machine);
  VirtualMachine truth = testing::smooth_machine(11);
  testing::Noise built(3);
  testing::ProbingPlan plan = testing::two_top_plan();
  plan.faces = testing::as_built(plan.faces, built, 20e-3, 50e-6);

  const Model first = identify(as_observations(probed(truth, plan, nullptr, 1)), machine).model;
  const std::unique_ptr<PlayedCompensation> tables = loaded(how, machine, first);
  const double bare_um = remaining_um(truth, nullptr), compensated_um = remaining_um(truth, tables.get());
  EXPECT_LT(compensated_um, share_left * bare_um);

  // A crash: the tilting axis stands elsewhere and its bearing has suffered.
  const auto sound = truth.axis('A').errors;
  truth.axis('A').errors = [sound, &crash = GetParam()](const testing::RotaryPosition& q) {
    testing::AxisErrors e = sound(q);
    e.translation_mm.y() += crash.crash_mm * std::sin(q.A_rad);
    e.rotation_rad.x() += crash.crash_rad * std::sin(q.A_rad);
    return e;
  };
  const double crashed_um = remaining_um(truth, tables.get());
  EXPECT_GT(crashed_um, 3 * compensated_um);

  const ObservationSet as_shown = as_observations(probed(truth, plan, tables.get(), 2));
  const Model second = identify(bare_readings(as_shown, *tables, chain), machine).model;
  const std::unique_ptr<PlayedCompensation> updated = loaded(how, machine, second);
  const double updated_um = remaining_um(truth, updated.get());
  EXPECT_LT(updated_um, 1.3 * compensated_um);

  // The same with the tables forgotten: what is loaded then takes the place of what it came on top of.
  const Model forgotten = identify(as_shown, machine).model;
  EXPECT_GT(remaining_um(truth, loaded(how, machine, forgotten).get()), worse_forgotten * updated_um);

  // Measured once more, now with the new tables: what the readings show as they are is what is left.
  const auto shown_um = [&](const PlayedCompensation& played, std::uint64_t seed) {
    const Model left = identify(as_observations(probed(truth, plan, &played, seed)), machine).model;
    return remaining_um(testing::perfect_machine("w C' A' Y' b X Z t"),
                        std::make_unique<PlayedModel>(left, chain, machine.limits).get());
  };
  EXPECT_LT(shown_um(*updated, 4), 0.4 * shown_um(*tables, 5));
}

// HEIDENHAIN's columns hold less, FANUC's pitch tables nothing but the axes' own angles.
INSTANTIATE_TEST_SUITE_P(Compensations, Active,
                         ::testing::Values(SwitchedOn{"model"}, SwitchedOn{"linuxcnc"}, SwitchedOn{"isg-twincat"},
                                           SwitchedOn{"sinumerik-840d"}, SwitchedOn{"aerotech"},
                                           SwitchedOn{"heidenhain", 0.2, 3, 60e-3, 300e-6},
                                           SwitchedOn{"fanuc-30i", 0.8, 1.3, 0, 8e-4}),
                         [](const auto& of) {
                           std::string name = of.param.name;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST(Active, DisplacementsAndRotationsAreThoseOfTheMachineToo) {
  // A perfect machine that is told to stand 1 mrad further in C and 5 um beside: it does, and the readings say so.
  struct Constant : PlayedCompensation {
    AxisCorrection at(const Situation&) const override { return {{5e-3, 0, 0}, 0, 1e-3}; }
  };
  const KinematicChain chain(testing::plain_machine());
  ObservationSet set{.files = {"shown.csv"}, .points = {"ball"}, .artifacts = {""}};
  Observation ball{.kind = ReadingKind::displacement, .line = 2, .position_mm = {100, 0, 0}, .direction = {0, 1, 0}};
  ball.value = 0.1;  // 100 mm x 1 mrad
  Observation along = ball;
  along.direction = {1, 0, 0};
  along.value = -5e-3 - 100 * (1 - std::cos(1e-3));
  Observation encoder{.kind = ReadingKind::rotation, .line = 4, .direction = {0, 0, 1}, .value = 1e-3};
  set.rows = {ball, along, encoder};
  set.rows[0].value = 100 * std::sin(1e-3);
  const ObservationSet bare = bare_readings(set, Constant{}, chain);
  for (const Observation& o : bare.rows) {
    EXPECT_NEAR(o.value, 0, 1e-12);
    EXPECT_NEAR(o.at.c.in_radians(), 1e-3, 1e-15);
  }
}

}  // namespace
}  // namespace trunnion
