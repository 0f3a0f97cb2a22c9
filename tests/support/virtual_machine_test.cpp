#include "support/virtual_machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/noise.h"
#include "support/undeclared_effects.h"

namespace trunnion::testing {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kPrinted = 6e-11;      // mm or rad: half a unit of the tenth decimal, and rounding
constexpr double kRounding_mm = 2e-13;  // a few roundings of 100 mm

constexpr double kDegree = std::numbers::pi / 180;

VirtualMachine seed_machine() { return perfect_machine("w C' A' Y' b X Z t"); }

void set_errors(VirtualMachine& machine, char axis, const AxisErrors& constant) {
  machine.axis(axis).errors = [constant](const RotaryPosition&) { return constant; };
}

/// Errors that stand at every position but, if asked, not at the reference pose.
VirtualMachine example(bool at_reference) {
  VirtualMachine machine = seed_machine();
  const auto where = [at_reference](const AxisErrors& errors) {
    return
        [=](const RotaryPosition& q) { return q.A_rad == 0 && q.C_rad == 0 && !at_reference ? AxisErrors{} : errors; };
  };
  machine.axis('A').errors = where(um_urad(10, -20, 30, 40, -50, 60));
  machine.axis('C').errors = where(um_urad(-5, 15, -25, -30, 20, 10));
  return machine;
}

Face face_at(const Vector3d& point, const Vector3d& outward) { return {"1S1", "1", point, outward, point, outward}; }

MachineState at(double A_deg, double C_deg, const Vector3d& tip = Vector3d::Zero()) {
  MachineState state;
  state.rotary = ac_degrees(A_deg, C_deg);
  state.tip_r_mm = tip;
  return state;
}

TEST(VirtualMachine, PlacesAWorkpiecePointWhereTheProductOfEq3SaysItIs) {
  const VirtualMachine machine = example(true);
  const Vector3d w(90, -70, 110);
  const Vector3d actual = machine.r_from_w(at(-30, 60)) * w;
  const Vector3d nominal = machine.r_from_w_nominal(ac_degrees(-30, 60)) * w;
  EXPECT_LT((actual - Vector3d(105.6193291242, 92.1750597379, 73.7963457864)).cwiseAbs().maxCoeff(), kPrinted);
  EXPECT_LT((nominal - Vector3d(105.6217782649, 92.1891108675, 73.7916512460)).cwiseAbs().maxCoeff(), kPrinted);

  Eigen::Matrix<double, 3, 4> rows;
  rows << .4999679912, -.8660438816, -.0000533021, .0050014281,  //
      .7500336575, .4329644011, .4999913399, -.0195087529,       //
      -.4329913629, -.2500196442, .8660304020, .0008491346;
  EXPECT_LT((machine.r_from_w(at(-30, 60)).matrix().topRows<3>() - rows).cwiseAbs().maxCoeff(), kPrinted);
}

TEST(VirtualMachine, ItsPoseErrorAtTheReferencePoseIsTakenOffExactly) {
  const AxisErrors error = example(true).pose_error(ac_degrees(-30, 60));
  const Vector3d um(-1.82809, -23.59447, -2.56621), urad(-20.98193, -57.18830, -5.13429);
  EXPECT_LT((error.translation_mm * 1e3 - um).cwiseAbs().maxCoeff(), 6e-6);
  EXPECT_LT((error.rotation_rad * 1e6 - urad).cwiseAbs().maxCoeff(), 6e-6);
  const AxisErrors reference = example(true).pose_error({});
  EXPECT_LT(reference.translation_mm.norm() + reference.rotation_rad.norm(), 1e-15);
}

/// Odd in the errors, so that what is left of the slope at zero is of third order.
AxisErrors central_slope(const VirtualMachine& machine, const RotaryPosition& position) {
  constexpr double kStep = .1;
  AxisErrors slope;
  for (const double step : {-kStep, kStep}) {
    VirtualMachine scaled = machine;
    for (char name : {'A', 'C'})
      scaled.axis(name).errors = [step, full = machine.axis(name).errors](const RotaryPosition& q) {
        const AxisErrors e = full(q);
        return AxisErrors{step * e.translation_mm, step * e.rotation_rad};
      };
    const AxisErrors error = scaled.pose_error(position);
    slope.translation_mm += error.translation_mm / (2 * step);
    slope.rotation_rad += error.rotation_rad / (2 * step);
  }
  return slope;
}

TEST(VirtualMachine, IsToFirstOrderTheSumOfEq11) {
  const AxisErrors absolute = central_slope(example(false), ac_degrees(-30, 60));
  const AxisErrors gauged = central_slope(example(true), ac_degrees(-30, 60));
  constexpr double kPrinted_um = 1e-8;  // or urad: third order 2e-9, rounding 2e-9
  const auto near = [kPrinted_um](const Vector3d& found, const Vector3d& wanted) {
    EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), kPrinted_um) << found.transpose();
  };
  near(absolute.translation_mm * 1e3, {5, -19.5096189432, .8493649054});
  near(absolute.rotation_rad * 1e6, {10, -27.6794919243, 58.6602540378});
  near(gauged.translation_mm * 1e3, {-1.8301270189, -23.5945554338, -2.5656986041});
  near(gauged.rotation_rad * 1e6, {-20.9807621135, -57.1891108675, -5.1313972081});
}

/// The A map and the C map of Eq. (12) and (13) on six C angles, to first order.
struct Maps {
  std::map<double, AxisErrors> a;
  std::map<std::pair<double, double>, AxisErrors> c;
};
Maps split_maps(const VirtualMachine& machine) {
  Maps maps;
  for (double a : {0., -30., -60., -90.}) {
    AxisErrors mean;
    for (int j = 0; j < 6; ++j) {
      const AxisErrors error = machine.pose_error(ac_degrees(a, 60 * j));
      mean.translation_mm += error.translation_mm / 6;
      mean.rotation_rad += error.rotation_rad / 6;
    }
    maps.a[a] = mean;
    const Eigen::Matrix3d back = AngleAxisd(-a * kDegree, Vector3d::UnitX()).matrix();
    for (int j = 0; j < 6; ++j) {
      const AxisErrors error = machine.pose_error(ac_degrees(a, 60 * j));
      maps.c[{a, 60. * j}] = {back * (error.translation_mm - mean.translation_mm),
                              back * (error.rotation_rad - mean.rotation_rad)};
    }
  }
  return maps;
}

constexpr double kFirstOrder = 1e-4;  // scale at which 20 um and 30 urad leave 1e-7 of themselves to second order

void expect_um_urad(const AxisErrors& found, const Vector3d& um, const Vector3d& urad, double tolerance) {
  EXPECT_LT((found.translation_mm * 1e3 / kFirstOrder - um).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LT((found.rotation_rad * 1e6 / kFirstOrder - urad).cwiseAbs().maxCoeff(), tolerance);
}

AxisErrors small(double ex, double ey, double ez, double ea, double eb, double ec) {
  AxisErrors e = um_urad(ex, ey, ez, ea, eb, ec);
  return {kFirstOrder * e.translation_mm, kFirstOrder * e.rotation_rad};
}

TEST(VirtualMachine, ConstantsOfCStandInBothMaps) {
  VirtualMachine machine = seed_machine();
  set_errors(machine, 'C', small(20, 10, 0, 30, -20, 0));
  const Maps maps = split_maps(machine);
  for (const auto& [a, found] : maps.a) {
    const double c = std::cos(a * kDegree), s = std::sin(a * kDegree);
    expect_um_urad(found, {20, 10 * c, 10 * s}, {30, -20 * c, -20 * s}, 1e-6);
  }
  for (double a : {0., -30., -60., -90.}) {
    expect_um_urad(maps.c.at({a, 0}), {-20, -10, 0}, {-30, 20, 0}, 1e-6);
    expect_um_urad(maps.c.at({a, 60}), {-1.34, -22.32, 0}, {-32.32, -15.98, 0}, .0051);
    expect_um_urad(maps.c.at({a, 180}), {20, 10, 0}, {30, -20, 0}, 1e-6);
  }
}

TEST(VirtualMachine, ConstantsOfAStandInBothMaps) {
  VirtualMachine machine = seed_machine();
  set_errors(machine, 'A', small(0, 20, 10, 0, -20, 10));
  const Maps maps = split_maps(machine);
  expect_um_urad(maps.a.at(0), {0, 20, 0}, {0, -20, 0}, 1e-6);
  expect_um_urad(maps.a.at(-30), {0, 15, 1.34}, {0, -25, 1.34}, .0051);
  expect_um_urad(maps.a.at(-60), {0, 11.34, 5}, {0, -28.66, 5}, .0051);
  expect_um_urad(maps.a.at(-90), {0, 10, 10}, {0, -30, 10}, 1e-6);
}

TEST(VirtualMachine, TurnsAboutAxesThatDoNotCrossAndTakesErrorsAtTheirOrigins) {
  VirtualMachine machine = seed_machine();
  machine.axis('A').origin_mm = {0, 5, -20};
  machine.axis('C').origin_mm = {3, -58, 0};
  // By hand: Rz(90) about (3, -58) takes (13, -58, 7) to (3, -48, 7); Rx(-90) about (y 5, z -20), (y, z) -> (z, -y), to
  // (3, 32, 33).
  const Vector3d moved = machine.r_from_w_nominal(ac_degrees(-90, 90)) * Vector3d(13, -58, 7);
  EXPECT_LT((moved - Vector3d(3, 32, 33)).norm(), kRounding_mm);

  // ECC of 10 urad turns about C's own line: its point stays, a point 100 mm along X moves 1 um along Y.
  set_errors(machine, 'C', um_urad(0, 0, 0, 0, 0, 10));
  EXPECT_LT((machine.r_from_w(at(0, 0)) * Vector3d(3, -58, 0) - Vector3d(3, -58, 0)).norm(), kRounding_mm);
  EXPECT_NEAR((machine.r_from_w(at(0, 0)) * Vector3d(103, -58, 0)).y(), -57.999, 1e-9);
  machine.axis('C').error_point_mm = Vector3d::Zero();
  EXPECT_NEAR((machine.r_from_w(at(0, 0)) * Vector3d(100, 0, 0)).y(), .001, 1e-9);
}

TEST(VirtualMachine, AnAxisThatCountsTheOtherWayKeepsRightHandedErrors) {
  VirtualMachine machine = seed_machine();
  machine.axis('A').direction = -Vector3d::UnitX();
  set_errors(machine, 'A', um_urad(0, 0, 0, 10, 0, 0));
  EXPECT_LT((machine.r_from_w_nominal(ac_degrees(90, 0)) * Vector3d(0, 0, 1) - Vector3d(0, 1, 0)).norm(), kRounding_mm);
  EXPECT_NEAR((machine.r_from_w(at(0, 0)) * Vector3d(0, 100, 0)).z(), .001, 1e-9);
}

TEST(VirtualMachine, ATouchOfAPerfectMachineIsNominal) {
  const VirtualMachine machine = seed_machine();
  const Face face = face_at({110, -90, 100}, {1, 0, 0});
  for (double a : {0., -30., -90.})
    for (double c : {0., 60., 250.}) {
      const MachineState state = at(a, c);
      EXPECT_LT((machine.touch(face, state) - machine.nominal_contact_r_mm(face, state.rotary)).norm(), kRounding_mm);
    }
}

TEST(VirtualMachine, ATouchEndsWhereTheRayMeetsTheRealFace) {
  VirtualMachine machine = seed_machine();
  set_errors(machine, 'C', um_urad(0, 0, 0, 0, 0, 2e3));
  // ECC = 2 mrad turns the +X face at x = 50; the ray at y = 30, z = 10 along -X meets it where
  // x cos e + y sin e = 50, x = (50 - 30 sin e) / cos e.
  const Face face = face_at({50, 30, 10}, {1, 0, 0});
  const double e = 2e-3;
  const Vector3d contact = machine.touch(face, at(0, 0));
  EXPECT_NEAR(contact.x(), (50 - 30 * std::sin(e)) / std::cos(e), kRounding_mm);
  EXPECT_EQ(contact.y(), 30);
  EXPECT_EQ(contact.z(), 10);
  // A ball of 3 mm meets the plane 3 mm (1 / cos e - 1) before its centre line does.
  machine.ball_radius_mm = 3;
  EXPECT_NEAR(machine.touch(face, at(0, 0)).x(), (50 - 30 * std::sin(e)) / std::cos(e) + 3 / std::cos(e) - 3,
              kRounding_mm);
}

TEST(VirtualMachine, ATouchReadsTheDeviationAlongItsApproachToFirstOrder) {
  VirtualMachine machine = example(false);
  add_linear_scale(machine, 'X', 20e-6);
  add_squareness(machine, "YZ", 15e-6);
  const Vector3d outwards[] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
  for (const Vector3d& outward : outwards) {
    const Face face = face_at({90, -70, 110}, outward);
    MachineState state = at(-30, 60);
    const Vector3d nominal = machine.nominal_contact_r_mm(face, state.rotary);
    const Vector3d n = machine.approach_r(face, state.rotary);
    state.tip_r_mm = nominal;
    const double reading = n.dot(machine.touch(face, state) - nominal);
    EXPECT_NEAR(reading, n.dot(machine.deviation_mm(state)), 3e-6) << outward.transpose();
    EXPECT_GT(std::abs(reading), 1e-3);
  }
}

/// One effect, one touch at (A, C) of a face whose approach is n, by hand. um.
double reading_um(const VirtualMachine& machine, const Face& face, const MachineState& state) {
  const Vector3d n = machine.approach_r(face, state.rotary);
  return 1e3 * n.dot(machine.touch(face, state) - machine.nominal_contact_r_mm(face, state.rotary));
}

TEST(UndeclaredEffects, HaveTheSignsOfTheDeviation) {
  const Face minus_x = face_at({-40, 30, 100}, {-1, 0, 0});  // approach n = +X
  const Face minus_y = face_at({-40, 30, 100}, {0, -1, 0});  // n = +Y
  const Face top = face_at({-40, 30, 100}, {0, 0, 1});       // n = -Z
  const auto with = [](auto&& add) {
    VirtualMachine machine = seed_machine();
    add(machine);
    return machine;
  };
  const MachineState home = at(0, 0);
  constexpr double kSecondOrder_um = 2e-4;
  const auto expect = [&](const VirtualMachine& m, const Face& f, const MachineState& s, double um, double tolerance) {
    EXPECT_NEAR(reading_um(m, f, s), um, tolerance) << f.nominal_outward_w.transpose();
  };
  // d_x = -k x with x = -40: +.8 um; n . d = .8.
  expect(with([](auto& m) { add_linear_scale(m, 'X', 20e-6); }), minus_x, home, .8, kSecondOrder_um);
  expect(with([](auto& m) { add_squareness(m, "XY", 10e-6); }), minus_x, home, -.3, kSecondOrder_um);
  expect(with([](auto& m) { add_squareness(m, "XZ", 10e-6); }), minus_x, home, -1, kSecondOrder_um);
  expect(with([](auto& m) { add_squareness(m, "YZ", 10e-6); }), minus_y, home, 1, kSecondOrder_um);
  expect(with([](auto& m) { add_straightness(m, "EZX", [](double x) { return x * x * 1e-6; }); }), top, home, 1.6,
         1e-9);
  expect(with([](auto& m) { add_linear_periodic(m, 'Y', .5e-3, 120, 0); }), minus_y, home, 0, 1e-9);
  expect(with([](auto& m) { add_linear_periodic(m, 'Y', .5e-3, 60, 0); }), minus_y, home, .5, 1e-9);
  for (const Face& face : {minus_x, face_at({-40, 30, 100}, {1, 0, 0})})
    expect(with([](auto& m) { add_linear_backlash(m, 'X', 3e-3); }), face, home, 1.5, 1e-9);
  // ECY of 10 urad (per 30 mm) turns the table: d_x = -10 urad * 30 mm, d_y = 10 urad * -40 mm.
  const auto yaw = [](double y) { return y * (10e-6 / 30); };
  expect(with([&](auto& m) { add_table_angular(m, "ECY", yaw); }), minus_x, home, -.3, kSecondOrder_um);
  expect(with([&](auto& m) { add_table_angular(m, "ECY", yaw); }), minus_y, home, -.4, 3e-4);
  // EAX of the tool, 100 mm long: d = -th ex x (0,0,-100) = -th (0, 100, 0).
  MachineState with_tool = home;
  with_tool.tool_length_mm = 100;
  expect(with([](auto& m) { add_tool_angular(m, "EAX", [](double) { return 10e-6; }); }), minus_y, with_tool, -1, 1e-6);

  MachineState back = home;
  back.rotary_sense = {-1, 1, -1};
  // C short by 10 urad: d = -10 urad ez x p = -10e-6 (-30, -40) -> (.3, .4) um.
  expect(with([](auto& m) { add_rotary_backlash(m, 'C', 10e-6); }), minus_x, back, .3, kSecondOrder_um);
  expect(with([](auto& m) { add_rotary_backlash(m, 'C', 10e-6); }), minus_y, back, .4, 3e-4);
  expect(with([](auto& m) { add_rotary_backlash(m, 'C', 10e-6); }), minus_y, home, 0, 1e-9);
  expect(with([](auto& m) { add_rotary_backlash(m, 'A', 10e-6); }), top, back, .3, kSecondOrder_um);
  expect(with([](auto& m) { add_cyclic_error(m, 'C', 3, 10e-6, 0); }), minus_y, home, -.4, 3e-4);
  MachineState loaded = home;
  loaded.covariates = {{"load_kg", 50}, {"A_clamped", 1}};
  expect(with([](auto& m) { add_brake_clamp(m, 'A', "A_clamped", 10e-6); }), top, loaded, -.3, kSecondOrder_um);
  expect(with([](auto& m) { add_brake_clamp(m, 'A', "A_clamped", 10e-6); }), top, home, 0, 1e-9);
  expect(with([](auto& m) { add_payload_sag(m, "load_kg", 0, 1e-6, 90 * kDegree); }), top, loaded, -1.5, 3e-4);
  MachineState later = home;
  later.time_s = 600;
  later.temperature_C = 22;
  later.order = 20;
  later.order_in_pose = 4;
  later.repeat = 1;
  expect(with([](auto& m) { add_thermal_drift(m, um_urad(0, 0, 4, 0, 0, 0), 600); }), top, later,
         -4 * (1 - std::exp(-1)), 1e-9);
  expect(with([](auto& m) { add_temperature(m, um_urad(1, 0, 0, 0, 0, 0)); }), minus_x, later, 2, 1e-9);
  expect(with([](auto& m) { add_probe_lobing(m, 3, .4e-3, .1e-3); }), minus_x, home, .4, 1e-9);
  expect(with([](auto& m) { add_probe_lobing(m, 3, .4e-3, .1e-3); }), minus_y, home, -.1, 1e-9);
  expect(with([](auto& m) { add_probe_lobing(m, 3, .4e-3, .1e-3); }), top, home, 0, 1e-9);
  expect(with([](auto& m) { add_probe_pretravel(m, .6e-3); }), top, home, .6, 1e-9);
  expect(with([](auto& m) { add_first_touches(m, {1e-3, 0, 0}, 10); }), minus_x, later, std::exp(-2), 1e-9);
  expect(with([](auto& m) { add_settling(m, {1e-3, 0, 0}); }), minus_x, later, 4, 1e-9);
  const auto kelvin = [](const MachineState& s) { return s.temperature_C - 20; };
  expect(with([&](auto& m) { add_artifact_expansion(m, 23e-6, kelvin); }), top, later, -4.6, 1e-9);
  expect(with([](auto& m) { add_artifact_slip(m, "1", um_urad(2, 0, 0, 0, 0, 0), 20); }), minus_x, later, 2, 1e-9);
  expect(with([](auto& m) { add_artifact_slip(m, "1", um_urad(2, 0, 0, 0, 0, 0), 21); }), minus_x, later, 0, 1e-9);
  expect(with([](auto& m) { add_artifact_slip(m, "2", um_urad(2, 0, 0, 0, 0, 0), 20); }), minus_x, later, 0, 1e-9);
  expect(with([](auto& m) {
           add_artifact_creep(m, "1", {2e-3, 0, 0}, 600);
         }),
         minus_x, later, 2 * (1 - std::exp(-1)), 1e-9);
  expect(with([](auto& m) { add_pass_shift(m, 1, {2e-3, 0, 0}); }), minus_x, later, 2, 1e-9);
  expect(with([](auto& m) { add_pass_shift(m, 1, {2e-3, 0, 0}); }), minus_x, home, 0, 1e-9);
}

TEST(UndeclaredEffects, OfTheTableAreNoneAtTheReferencePoseWhateverTheyAre) {
  VirtualMachine machine = seed_machine();
  add_payload_sag(machine, "load_kg", 30e-6, 0, 40 * kDegree);
  add_cyclic_error(machine, 'C', 6, 10e-6, 0);
  EXPECT_LT(machine.pose_error({}).rotation_rad.norm(), 1e-15);
  EXPECT_NEAR(machine.pose_error(ac_degrees(-40, 0)).rotation_rad.x(), -30e-6 * std::sin(40 * kDegree), 1e-14);
}

TEST(VirtualMachine, DisplacementRotationAndPoseSeeTheTable) {
  const VirtualMachine machine = example(false);
  const MachineState state = at(-30, 60, Vector3d(105.6217782649, 92.1891108675, 73.7916512460));
  const Vector3d d = Vector3d(105.6193291242, 92.1750597379, 73.7963457864) - state.tip_r_mm;
  const Vector3d n = Vector3d(1, 2, 2) / 3;
  EXPECT_NEAR(machine.displacement_mm({90, -70, 110}, n, state), n.dot(d), 2 * kPrinted);
  // First order (10, -27.68, 58.66) urad; second order is the paper's 1e-9.
  EXPECT_NEAR(machine.rotation_rad(Vector3d::UnitZ(), state), 58.6602540378e-6, 5e-9);
  EXPECT_NEAR(machine.rotation_rad(Vector3d::UnitX(), state), 10e-6, 5e-9);

  const Isometry3d instrument = Eigen::Translation3d(-500, 20, 300) * AngleAxisd(.7, Vector3d(1, 2, 3).normalized());
  const Isometry3d mount = Eigen::Translation3d(40, 50, 60) * AngleAxisd(-2, Vector3d::UnitY());
  const Isometry3d seen = machine.pose(instrument, mount, state);
  EXPECT_LT((instrument.inverse() * seen * mount.inverse() * Vector3d(90, -70, 110) -
             Vector3d(105.6193291242, 92.1750597379, 73.7963457864))
                .norm(),
            4 * kPrinted);
}

Command command(const Vector3d& xyz, const RotaryPosition& rotary, double length_mm, Tcp tcp) {
  Command c;
  c.xyz_mm = xyz;
  c.rotary = rotary;
  c.tool_length_mm = length_mm;
  c.tcp = tcp;
  return c;
}

TEST(VirtualMachine, PlaysATcpProgramOnAPerfectMachineOfAnyStructure) {
  for (const char* structure :
       {"w C' A' Y' b X Z t", "w C' B' X' b Y Z t", "w C' Y' b X Z B t", "w Y' b X Z C A t", "w b X Y Z C B t"}) {
    VirtualMachine machine = perfect_machine(structure);
    for (auto* side : {&machine.workpiece_axes, &machine.tool_axes})
      for (RotaryAxis& axis : *side) axis.origin_mm = axis.name == 'C' ? Vector3d(2, 3, 0) : Vector3d(0, 4, 150);
    const RotaryPosition q{-25 * kDegree, -25 * kDegree, 130 * kDegree};
    const Vector3d tip(20, -30, 40);
    const ToolInWorkpiece tool = machine.play({command(tip, q, 120, Tcp::on)}).front();
    EXPECT_LT((tool.tip_w_mm - tip).norm(), kRounding_mm) << structure;
    const MachineState state = machine.commanded_state(command(tip, q, 120, Tcp::on));
    const Vector3d axis =
        machine.r_from_w_nominal(q).linear().transpose() * machine.r_from_tool_nominal(state).linear().col(2);
    EXPECT_LT((tool.axis_w - axis).norm(), 1e-15) << structure;
  }
}

TEST(VirtualMachine, PlaysMachineCoordinates) {
  const VirtualMachine trunnion = seed_machine();
  // A = -90, C = 90: W (x, y, z) stands at R (-y, z, -x) ... Rz(90): (-y, x, z), Rx(-90): (x, y, z) -> (x, z, -y).
  const ToolInWorkpiece tool = trunnion.play({command({-5, 7, -3}, ac_degrees(-90, 90), 80, Tcp::off)}).front();
  EXPECT_LT((tool.tip_w_mm - Vector3d(3, 5, 7)).norm(), kRounding_mm);
  EXPECT_LT((tool.axis_w - Vector3d(-1, 0, 0)).norm(), 1e-15);

  // Head-head, C carries A, pivot 150 mm above the nose, L = 100: the tip swings from 250 below the pivot to 250 beside
  // it.
  VirtualMachine head = perfect_machine("w Y' b X Z C A t");
  head.axis('A').origin_mm = {0, 0, 150};
  const ToolInWorkpiece swung = head.play({command({10, 20, 30}, ac_degrees(-90, 90), 100, Tcp::off)}).front();
  EXPECT_LT((swung.tip_w_mm - Vector3d(260, 20, 280)).norm(), kRounding_mm);
  EXPECT_LT((swung.axis_w - Vector3d(-1, 0, 0)).norm(), 1e-15);

  // Head-table, B on the head and C under the workpiece: B = 90 puts the tip 250 mm towards -X of the pivot.
  VirtualMachine mixed = perfect_machine("w C' Y' b X Z B t");
  mixed.axis('B').origin_mm = {0, 0, 150};
  const ToolInWorkpiece seen = mixed.play({command({10, 20, 30}, bc_degrees(90, 90), 100, Tcp::off)}).front();
  // R: (10 - 250, 20, 30 + 250), the axis +X; W is turned by 90 deg: (x, y) -> (y, -x).
  EXPECT_LT((seen.tip_w_mm - Vector3d(20, 240, 280)).norm(), kRounding_mm);
  EXPECT_LT((seen.axis_w - Vector3d(0, -1, 0)).norm(), 1e-15);
}

TEST(VirtualMachine, AnUncorrectedProgramMissesByTheDeviation) {
  const VirtualMachine machine = example(true);
  const Vector3d wanted(90, -70, 110);
  const Command c = command(wanted, ac_degrees(-30, 60), 120, Tcp::on);
  const MachineState state = machine.commanded_state(c);
  const Vector3d missed_r = machine.r_from_w_nominal(c.rotary).linear() * (wanted - machine.play({c}).front().tip_w_mm);
  EXPECT_LT((missed_r - machine.deviation_mm(state)).norm(), 3e-6);  // 20 um turned by 100 urad

  // Commanded where the workpiece point really is, it meets it.
  Command corrected = c;
  corrected.tcp = Tcp::off;
  corrected.xyz_mm = machine.table_error(state) * state.tip_r_mm;
  EXPECT_LT((machine.play({corrected}).front().tip_w_mm - wanted).norm(), kRounding_mm);
}

TEST(VirtualMachine, AHeadIsReferredToTheReferencePoseToo) {
  VirtualMachine machine = perfect_machine("w Y' b X Z C A t");
  machine.axis('A').origin_mm = {0, 0, 150};
  set_errors(machine, 'A', um_urad(3, -4, 5, 20, -30, 10));
  set_errors(machine, 'C', um_urad(-6, 2, 1, 15, 5, -25));
  const ToolInWorkpiece home = machine.play({command({10, 20, 30}, {}, 100, Tcp::on)}).front();
  EXPECT_LT((home.tip_w_mm - Vector3d(10, 20, 30)).norm(), kRounding_mm);
  EXPECT_LT((home.axis_w - Vector3d::UnitZ()).norm(), 1e-15);
  // EAC = 15 urad before C's motion tilts the head alike at every C about R's X: nothing is left after the reference.
  VirtualMachine tilt = perfect_machine("w Y' b X Z C A t");
  set_errors(tilt, 'C', um_urad(0, 0, 0, 15, 0, 0));
  EXPECT_LT(
      (tilt.play({command({10, 20, 30}, ac_degrees(0, 90), 100, Tcp::on)}).front().tip_w_mm - Vector3d(10, 20, 30))
          .norm(),
      kRounding_mm);
  // EAA = 15 urad after C: at C = 90 it tilts about Y; the tip, 100 mm below, went (0, +1.5, 0) um and is now at (-1.5,
  // 0, 0).
  VirtualMachine carried = perfect_machine("w Y' b X Z C A t");
  set_errors(carried, 'A', um_urad(0, 0, 0, 15, 0, 0));
  const Vector3d off =
      carried.play({command({10, 20, 30}, ac_degrees(0, 90), 100, Tcp::on)}).front().tip_w_mm - Vector3d(10, 20, 30);
  EXPECT_LT((off - Vector3d(-1.5e-3, -1.5e-3, 0)).norm(), 1e-7);
}

/// A constant offset b of the tip is set up with the workpiece, which turns it: d = -(I - R) b.
TEST(VirtualMachine, ATableTurnsWhatTheHeadHadWrongAtTheSetUp) {
  VirtualMachine machine = perfect_machine("w C' Y' b X Z B t");
  set_errors(machine, 'B', um_urad(3, 4, 0, 0, 0, 0));
  MachineState state = at(0, 90, Vector3d(100, 50, 60));
  EXPECT_LT((machine.deviation_mm(state) - Vector3d(-7e-3, -1e-3, 0)).norm(), kRounding_mm);
  // The same touches show: what one reads at C = 90 beyond what it read at C = 0.
  for (const Vector3d& outward : {Vector3d(1, 0, 0), Vector3d(0, -1, 0)}) {
    const Face face = face_at({50, -100, 60}, outward);
    const double read_um = reading_um(machine, face, state) - reading_um(machine, face, at(0, 0));
    EXPECT_NEAR(read_um, 1e3 * machine.approach_r(face, state.rotary).dot(machine.deviation_mm(state)), 1e-9);
  }
  const Command c = command({50, -100, 60}, bc_degrees(0, 90), 80, Tcp::on);
  const Vector3d missed_w = c.xyz_mm - machine.play({c}).front().tip_w_mm;
  EXPECT_LT((missed_w - Vector3d(-1e-3, 7e-3, 0)).norm(), kRounding_mm);
}

TEST(VirtualMachine, KnowsTheSenseOfEveryMotionOfAProgram) {
  VirtualMachine machine = seed_machine();
  add_rotary_backlash(machine, 'C', 10e-6);
  std::vector<Command> program;
  for (double c : {0., 30., 10., 10., 20.}) program.push_back(command({100, 0, 0}, ac_degrees(0, c), 0, Tcp::on));
  const auto path = machine.play(program);
  for (std::size_t i = 0; i < path.size(); ++i)
    EXPECT_NEAR(path[i].tip_w_mm.y(), i == 2 || i == 3 ? 1e-3 : 0, 1e-9) << i;
  EXPECT_EQ(between(program[1], program[2], .25).rotary.C_rad, 30 * kDegree + .25 * (10 * kDegree - 30 * kDegree));
}

TEST(VirtualMachine, ErrorsOfAMotionAreThoseItWasMadeOf) {
  const AxisErrors errors{Vector3d(1, -2, 3), Vector3d(.1, -.2, .3)};
  const AxisErrors back = errors_of(error_transform(errors));
  EXPECT_LT((back.rotation_rad - errors.rotation_rad).norm(), 1e-15);
  EXPECT_EQ(back.translation_mm, errors.translation_mm);
}

TEST(VirtualMachine, RefusesAStructureItCannotBuild) {
  for (const char* wrong :
       {"", "w C' A' Y' X Z t", "C' A' b X Z t", "w C' Y' A' b X Z Q t", "w Y' C' A' b X Z t", "w b X Z C' t"})
    EXPECT_THROW(perfect_machine(wrong), std::invalid_argument) << wrong;
}

TEST(Noise, IsTheSameEverywhere) {
  // The first outputs of xoshiro256** from splitmix64(0), as published implementations give them.
  Noise noise(0);
  EXPECT_EQ(noise.bits(), 11091344671253066420U);
  EXPECT_EQ(noise.bits(), 13793997310169335082U);
}

TEST(Noise, HasTheMomentsOfANormalVariable) {
  Noise noise(7);
  constexpr int kDraws = 200000;
  double sum = 0, squares = 0, fourth = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = noise.normal();
    sum += z;
    squares += z * z;
    fourth += z * z * z * z;
  }
  EXPECT_NEAR(sum / kDraws, 0, .01);
  EXPECT_NEAR(squares / kDraws, 1, .015);
  EXPECT_NEAR(fourth / kDraws, 3, .1);
}

}  // namespace
}  // namespace trunnion::testing
