#include "conventions/machine_checks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometric_errors/rotary_errors.h"
#include "kinematics/kinematic_chain.h"
#include "linear_algebra/factors.h"
#include "model/effects/location_errors.h"
#include "model/model.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kCross_mm = 1e-6;     // what is written as crossing crosses
constexpr double kSquare = 1e-9;       // of a direction cosine
constexpr double kLaw_mm = 1e-9;       // rounding on some 100 mm and 0.05 mm, a thousand times smaller than a picometre
constexpr double kSecondOrder = 1e-3;  // of errors of 1 um and 10 urad: what first-order location errors leave aside
constexpr int kLocationErrors = 8;
constexpr double kSize_mm = 1e-3, kLever_mm = 100, kToolLength_mm = 150;
constexpr double kStrokeOfInches = 60;    // mm: no linear axis of a five-axis machine is that short, in inch many are
constexpr double kBallOfInches_mm = 0.2;  // a stylus ball of 6 mm is 0.118 in

std::string vector_text(const Eigen::Vector3d& v) {
  return "(" + formatted("%.6g", v.x()) + formatted(", %.6g", v.y()) + formatted(", %.6g)", v.z());
}

/// "+X" for a principal direction, else its components.
std::string direction_text(const Eigen::Vector3d& v) {
  for (Eigen::Index k = 0; k < 3; ++k)
    if (std::abs(std::abs(v[k]) - 1) < kSquare) return std::string(v[k] > 0 ? "+" : "-") + "XYZ"[k];
  return vector_text(v);
}

/// What a command of +10 deg does, in words that can be compared with the machine.
Check sense_of(const Machine& machine, const KinematicChain& chain, std::size_t index) {
  const RotaryJoint& joint = chain.rotary_joints()[index];
  const bool tilt = index == chain.tilt_index();
  const IndexedPosition at = tilt ? IndexedPosition{Angle::degrees(10), {}} : IndexedPosition{{}, Angle::degrees(10)};
  // A point 100 mm off the line, where it moves along one of R's axes as far as it can.
  Eigen::Index side = 0;
  joint.direction.cwiseAbs().minCoeff(&side);
  const Eigen::Vector3d arm = 100 * joint.direction.cross(Eigen::Vector3d::Unit(side)).normalized();
  const Eigen::Vector3d moved = chain.motion(index, at) * arm - arm;
  Check check{.id = std::string("senses.") + joint.letter, .outcome = Outcome::open, .found = {}, .advice = {}};
  check.found = std::string(1, joint.letter) + " turns " + (joint.side == Side::workpiece ? "the table" : "the tool") +
                " right-handed about " + direction_text(machine.axes.at(joint.letter).direction) +
                ": +10 deg moves a point " + vector_text(arm) + " mm off its line by " +
                vector_text(moved.unaryExpr([](double v) { return std::round(10 * v) / 10 + 0.0; })) + " mm";
  check.advice = "the sign test (-o DIR, then --form) shows it on the machine";
  return check;
}

Check angle_units(const Machine& machine) {
  Check check{.id = "units.strokes_deg",
              .outcome = Outcome::passed,
              .found = "strokes of rotary axes read as deg",
              .advice = {}};
  for (const Axis* axis : {&machine.tilt(), &machine.turn()}) {
    if (!axis->range_angle) continue;
    const double low = axis->range_angle->low.in_degrees(), high = axis->range_angle->high.in_degrees();
    if (std::max(std::abs(low), std::abs(high)) > 2 * std::numbers::pi + 0.01) continue;
    check.outcome = Outcome::warning;
    check.found = std::string("axis.") + axis->letter + ".range_deg: " + formatted("%.6g", low) +
                  formatted(" to %.6g", high) + " looks like rad (" + formatted("%.4g", low * 180 / std::numbers::pi) +
                  formatted(" to %.4g deg)", high * 180 / std::numbers::pi);
    check.advice = "degrees are wanted";
    return check;
  }
  return check;
}

Check length_units(const Machine& machine) {
  Check check{.id = "units.lengths_mm",
              .outcome = Outcome::passed,
              .found = "strokes and stylus ball read as mm",
              .advice = {}};
  for (const char letter : {'X', 'Y', 'Z'}) {
    const auto& stroke = machine.axes.at(letter).range_length;
    if (!stroke || (stroke->high - stroke->low).in_millimetres() > kStrokeOfInches) continue;
    check.outcome = Outcome::warning;
    check.found = std::string("axis.") + letter + ".range_mm: a stroke of " +
                  formatted("%.6g mm looks like inch", (stroke->high - stroke->low).in_millimetres());
    check.advice = "mm are wanted";
  }
  if (machine.probe.ball_radius.in_millimetres() < kBallOfInches_mm) {
    check.outcome = Outcome::warning;
    check.found =
        "probe.ball_radius_mm: " + formatted("%.6g", machine.probe.ball_radius.in_millimetres()) + " looks like inch";
    check.advice = "mm are wanted";
  }
  return check;
}

/// Whether the lines of the rotary axes meet, and where; only told where both carry the same side.
Check crossing(const KinematicChain& chain) {
  Check check{.id = "origin.crossing", .outcome = Outcome::passed, .found = {}, .advice = {}};
  const RotaryJoint &first = chain.rotary_joints()[0], &second = chain.rotary_joints()[1];
  if (first.side != second.side) {
    check.found = "one rotary axis carries the table, the other the tool: R's origin is the zero of the machine file";
    return check;
  }
  const Eigen::Vector3d between = second.origin_mm - first.origin_mm;
  const Eigen::Vector3d common = first.direction.cross(second.direction);
  if (common.norm() < 1e-6) {
    check.outcome = Outcome::failed;
    check.found = "the two rotary axes are parallel";
    check.advice = "see axis.*.direction";
    return check;
  }
  const double apart = std::abs(between.dot(common.normalized()));
  if (apart > kCross_mm) {
    check.found = "the rotary axes pass each other at " + formatted("%.6g", apart) +
                  " mm: R's origin is the zero of the machine file";
    check.advice = "readings must be told from that same zero";
    return check;
  }
  const double along = between.cross(second.direction).dot(common) / common.squaredNorm();
  const Eigen::Vector3d meeting = first.origin_mm + along * first.direction;
  check.found = "the rotary axes cross at " +
                vector_text(meeting.unaryExpr([](double v) { return std::round(1e6 * v) / 1e6 + 0.0; })) + " mm";
  if (meeting.norm() > kCross_mm && first.side == Side::workpiece) {
    check.outcome = Outcome::warning;
    check.advice = "R's origin is their crossing: origin_mm of both axes should be such that they cross at zero";
  }
  return check;
}

Check reference_pose(const Machine& machine) {
  Check check{.id = "reference.stroke",
              .outcome = Outcome::passed,
              .found = "the reference pose is within the strokes",
              .advice = {}};
  for (const Axis* axis : {&machine.tilt(), &machine.turn()})
    if (axis->range_angle && (axis->range_angle->low > Angle() || axis->range_angle->high < Angle())) {
      check.outcome = Outcome::failed;
      check.found =
          std::string("the reference pose, ") + axis->letter + " 0, is outside axis." + axis->letter + ".range_deg";
      check.advice = "errors are told relative to it, and contacts need it measured";
    }
  return check;
}

std::vector<IndexedPosition> positions_of(const Machine& machine) {
  std::vector<IndexedPosition> positions;
  Range<Angle> tilts{Angle::degrees(-90), Angle::degrees(30)};
  if (const auto& stroke = machine.tilt().range_angle)
    tilts = {std::max(tilts.low, stroke->low), std::min(tilts.high, stroke->high)};
  for (const double share : {0.0, 0.3, 0.7, 1.0})
    for (const double turn : {0.0, 70.0, 160.0, 290.0})
      positions.push_back({tilts.low + share * (tilts.high - tilts.low), Angle::degrees(turn)});
  return positions;
}

/// The gauge of the error functions on this machine: zero at the reference pose; constants of the twelve, taken
/// exactly, reach as far as the eight location errors, taken as they are fitted.
Check gauge(const Machine& machine, const KinematicChain& chain) {
  const std::vector<IndexedPosition> positions = positions_of(machine);
  const auto rows = 6 * static_cast<Eigen::Index>(positions.size());
  const EffectPtr location = make_location_errors(effect_context(machine));
  const ToolPlace tool{{}, kToolLength_mm};
  Eigen::MatrixXd twelve(rows, 12), eight(rows, 8);
  double at_reference = 0;
  for (Eigen::Index k = 0; k < 12; ++k) {
    RotaryErrors constant;
    const double size = k % 6 < 3 ? kSize_mm : kSize_mm / kLever_mm;
    ((k < 6 ? constant.tilt : constant.turn)) = PoseError::from_vector(size * Vector6d::Unit(k % 6));
    const auto error = [&](IndexedPosition at) {
      Vector6d e = relative_pose_error(chain, at, constant, constant, tool).vector() / kSize_mm;
      e.tail<3>() *= kLever_mm;
      return e;
    };
    at_reference = std::max(at_reference, error({}).norm());
    for (std::size_t i = 0; i < positions.size(); ++i)
      twelve.block<6, 1>(6 * static_cast<Eigen::Index>(i), k) = error(positions[i]);
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Matrix6Xd b = location->basis({.at = positions[i], .tool_length_mm = kToolLength_mm});
    b.bottomRows(3) *= kLever_mm;
    for (Eigen::Index k = 0; k < 8; ++k)
      if (location->parameters()[static_cast<std::size_t>(k)].unit == Unit::urad) b.col(k) /= kLever_mm;
    eight.middleRows<6>(6 * static_cast<Eigen::Index>(i)) = b;
  }
  // Freedoms are told from what second order makes of a constant.
  const auto left = [](const Eigen::MatrixXd& of, const Eigen::MatrixXd& by) {
    return Eigen::MatrixXd(of - by * LeastSquares(by, kSecondOrder).solve(of)).cwiseAbs().maxCoeff();
  };
  // Where one axis carries the tool, its constants move the tool against the set-up, which no location error does.
  const bool same_side = chain.rotary_joints()[0].side == chain.rotary_joints()[1].side;
  const double beyond = same_side ? std::max(left(eight, twelve), left(twelve, eight)) : 0.0;
  const auto rank = static_cast<int>(LeastSquares(eight, kSecondOrder).rank());
  Check check{.id = "law.gauge", .outcome = Outcome::passed, .found = {}, .advice = {}};
  check.found = "constants of the twelve errors leave nothing at the reference pose";
  if (same_side)
    check.found += "; they move the table in as many ways as the location errors, " + std::to_string(rank) + ", to " +
                   formatted("%.1e", beyond) + " of their size";
  if (at_reference > kSecondOrder || beyond > kSecondOrder || (same_side && rank != kLocationErrors)) {
    check.outcome = Outcome::failed;
    check.found += "; at the reference pose " + formatted("%.1e", at_reference) + " is left";
    check.advice = "this structure is not understood as it must be: correct nothing with it";
  }
  return check;
}

/// What the chain itself makes of a rotary axis that stands `zero` further than commanded: the error of the workpiece
/// against the tool at R's origin, the reference pose set up alike.
PoseError of_wrong_zero(const KinematicChain& chain, IndexedPosition at, const IndexedPosition& zero,
                        const ToolPlace& tool) {
  const auto moved = [&](IndexedPosition p) { return IndexedPosition{p.a + zero.a, p.c + zero.c}; };
  const Eigen::Isometry3d nominal = chain.r_from_w(at);
  PoseError error = pose_error(chain.r_from_w(moved(at)) * chain.r_from_w(moved({})).inverse(Eigen::Isometry) *
                               nominal.inverse(Eigen::Isometry));
  const Eigen::Vector3d gauge_line(0, 0, -tool.length_mm);
  const auto tip = [&](IndexedPosition p) -> Eigen::Vector3d {
    return chain.r_from_t(moved(p)) * gauge_line - chain.r_from_t(p) * gauge_line;
  };
  const auto turn = [&](IndexedPosition p) -> Eigen::Vector3d {
    const Eigen::AngleAxisd about(
        Eigen::Matrix3d(chain.r_from_t(moved(p)).linear() * chain.r_from_t(p).linear().transpose()));
    return about.angle() * about.axis();
  };
  const Eigen::Vector3d turned = turn(at) - nominal.linear() * turn({});
  error.rotation_rad -= turned;
  error.translation_mm -= tip(at) - nominal.linear() * tip({}) + tool.tip_r_mm.cross(turned);
  return error;
}

/// A constant about an axis' own line is a wrong zero of that axis, on the table's side as on the tool's: the error
/// functions must say of it what the chain says of the command. The signs of both stand or fall together.
Check axis_zero(const Machine& machine, const KinematicChain& chain) {
  constexpr double kZero_rad = 1e-5;
  const ToolPlace tool{{40, -30, 60}, kToolLength_mm};
  double largest = 0;
  for (std::size_t index = 0; index < chain.rotary_joints().size(); ++index) {
    const bool tilt = index == chain.tilt_index();
    RotaryErrors constant;
    (tilt ? constant.tilt : constant.turn).rotation_rad = kZero_rad * chain.rotary_joints()[index].direction;
    const Angle zero = Angle::radians(kZero_rad);
    for (const IndexedPosition at : positions_of(machine)) {
      const PoseError apart =
          relative_pose_error(chain, at, constant, constant, tool) -
          of_wrong_zero(chain, at, tilt ? IndexedPosition{zero, {}} : IndexedPosition{{}, zero}, tool);
      largest = std::max(
          {largest, apart.translation_mm.norm() / (kZero_rad * kLever_mm), apart.rotation_rad.norm() / kZero_rad});
    }
  }
  Check check{.id = "law.axis_zero", .outcome = Outcome::passed, .found = {}, .advice = {}};
  check.found = "a constant about an axis' own line displaces as a wrong zero of that axis does, to " +
                formatted("%.1e", largest) + " of it";
  if (largest > kSecondOrder) {
    check.outcome = Outcome::failed;
    check.advice = "this structure is not understood as it must be: correct nothing with it";
  }
  return check;
}

/// R's origin told elsewhere: axes of the table and points move along, deviations stay.
Check origin_shift(const Machine& machine) {
  const Eigen::Vector3d shift(31, -17, 53);
  Machine moved = machine;
  const KinematicChain chain(machine);
  for (const RotaryJoint& joint : chain.rotary_joints())
    if (joint.side == Side::workpiece) moved.axes.at(joint.letter).origin_mm += shift;
  Eigen::VectorXd values(8);
  const EffectPtr shape = make_location_errors(effect_context(machine));
  for (Eigen::Index k = 0; k < 8; ++k)
    values[k] = (shape->parameters()[static_cast<std::size_t>(k)].unit == Unit::um ? 0.01 : 5e-5) *
                (1 + 0.3 * static_cast<double>(k));
  const EffectPtr here = shape->with_parameters(values, {});
  const EffectPtr there = make_location_errors(effect_context(moved))->with_parameters(values, {});
  const Eigen::Vector3d point(60, -40, 90);
  double largest = 0, size = 0;
  for (const IndexedPosition at : positions_of(machine)) {
    const auto d = [&](const EffectPtr& effect, const Eigen::Vector3d& p) {
      const Situation s{.at = at, .point_r_mm = p, .tool_length_mm = kToolLength_mm};
      const Vector6d e = effect->basis(s) * effect->values();  // to first order, as it is fitted
      return Eigen::Vector3d(displacement_jacobian(p) * e);
    };
    const Eigen::Vector3d before = d(here, point);
    size = std::max(size, before.norm());
    largest = std::max(largest, (before - d(there, point + shift)).norm());
  }
  Check check{.id = "law.origin_shift", .outcome = Outcome::passed, .found = {}, .advice = {}};
  check.found = "with R's origin (31, -17, 53) mm elsewhere, deviations of " + formatted("%.1f um", 1e3 * size) +
                formatted(" change by %.1e um", 1e3 * largest);
  if (largest > kLaw_mm) {
    check.outcome = Outcome::failed;
    check.advice = "this structure is not understood as it must be: correct nothing with it";
  }
  return check;
}

}  // namespace

Checks machine_checks(const Machine& machine) {
  const KinematicChain chain(machine);
  return {sense_of(machine, chain, chain.tilt_index()),
          sense_of(machine, chain, chain.turn_index()),
          angle_units(machine),
          length_units(machine),
          crossing(chain),
          reference_pose(machine),
          gauge(machine, chain),
          axis_zero(machine, chain),
          origin_shift(machine)};
}

}  // namespace trunnion
