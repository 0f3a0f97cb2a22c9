#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

// A five-axis machine that really turns and touches: every transform is an exact rigid motion, nothing is linearised,
// and nothing of src/ is used, so that what it says can judge what the program says. Lengths are mm, angles rad. So:
//
//   VirtualMachine machine = perfect_machine("w C' A' Y' b X Z t");  // or smooth_machine(seed)
//   machine.axis('A').errors = [](const RotaryPosition& q) { return um_urad(0, 0, 0, 30 * std::sin(q.A_rad), 0, 0); };
//   add_squareness(machine, "XY", 15e-6);  // undeclared_effects.h
//   machine.tool_effects.push_back([](const MachineState& state) { ... });  // anything else, as an Eigen::Isometry3d
//   Noise noise(7);
//   auto rows = probe(machine, replica_plan(), {.sigma_mm = 0.175e-3}, noise);  // probing_plan.h
//   auto file = csv(rows);                                                      // observation_row.h
//   auto path = machine.play({{.xyz_mm = {10, 0, 50}, .rotary = ac_degrees(-30, 60), .tcp = Tcp::on}});

namespace trunnion::testing {

/// Six errors of one axis at one position, right-handed about R's axes: EX. EY. EZ. in mm, EA. EB. EC. in rad.
struct AxisErrors {
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
};

/// (EX, EY, EZ in um; EA, EB, EC in urad).
AxisErrors um_urad(double ex, double ey, double ez, double ea, double eb, double ec);

/// Tx Ty Tz Rx Ry Rz, in this order and exactly: the E of Eq. (3).
Eigen::Isometry3d error_transform(const AxisErrors& errors);

/// The six numbers whose error_transform is `motion`; |EB| < 90 deg.
AxisErrors errors_of(const Eigen::Isometry3d& motion);

/// Commanded rotary positions; an axis that the machine has not is ignored.
struct RotaryPosition {
  double A_rad = 0;
  double B_rad = 0;
  double C_rad = 0;
  double of(char axis) const;
};
RotaryPosition ac_degrees(double A_deg, double C_deg);
RotaryPosition bc_degrees(double B_deg, double C_deg);

/// Everything an error may depend on.
struct MachineState {
  RotaryPosition rotary;
  Eigen::Vector3d tip_r_mm = Eigen::Vector3d::Zero();  ///< where the tool tip nominally is, in R
  double tool_length_mm = 0;                           ///< from the spindle's gauge point to the tip
  double time_s = 0;
  double temperature_C = 20;
  RotaryPosition rotary_sense{1, 1, 1};                    ///< +1 or -1: sense of each rotary axis' last motion
  Eigen::Vector3d linear_sense = Eigen::Vector3d::Zero();  ///< the same of X Y Z; 0: never moved
  int order = 0;                                           ///< touches before this one, over all passes
  int order_in_pose = 0;                                   ///< touches before this one since the rotary axes moved
  int repeat = 0;
  std::map<std::string, double> covariates;         ///< load_kg, A_clamped, ...
  double covariate(const std::string& name) const;  ///< 0 where it is not known
};

enum class Side { workpiece, tool };

/// A rotary axis of the chain. What it carries turns right-handed about `direction` as the command grows. On the
/// workpiece side `origin_mm` is a point of the axis line in R at A = B = C = 0. On the tool side it is counted from
/// the spindle's gauge point (tool length 0) in the same pose: a pivot 150 mm above the spindle nose is (0, 0, 150).
struct RotaryAxis {
  char name = 'A';
  Side side = Side::workpiece;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
  std::function<AxisErrors(const RotaryPosition&)> errors;  ///< none: a perfect axis
  std::optional<Eigen::Vector3d> error_point_mm;            ///< where its six errors are taken; none: at origin_mm
};

/// A spot of a plane face on the table, where it is believed to be and where it really is, in W.
struct Face {
  std::string point;
  std::string artifact;
  Eigen::Vector3d nominal_w_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d nominal_outward_w = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d actual_w_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d actual_outward_w = Eigen::Vector3d::UnitZ();
};

/// What an error of the measurement may depend on: the state when the probe triggers, and what it touches.
struct TouchState {
  MachineState machine;
  Face face;
  Eigen::Vector3d approach_r = -Eigen::Vector3d::UnitZ();
};

using RigidEffect = std::function<Eigen::Isometry3d(const MachineState&)>;
using JointEffect = std::function<double(const MachineState&)>;
using ArtifactEffect = std::function<Eigen::Isometry3d(const TouchState&)>;
using ReadingEffect = std::function<double(const TouchState&)>;

/// What a program commands at one instant. TCP off: XYZ + offset is where the tip stands in R while all tool-side
/// rotary axes are at zero (length compensation along Z). TCP on: XYZ + offset is the tip in W, which turns with the
/// table.
enum class Tcp { off, on };
struct Command {
  Eigen::Vector3d xyz_mm = Eigen::Vector3d::Zero();
  RotaryPosition rotary;
  double tool_length_mm = 0;
  Tcp tcp = Tcp::off;
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();
  double time_s = 0;
  double temperature_C = 20;
  std::map<std::string, double> covariates;
};

/// The tool as seen from the workpiece; the axis points from the tip to the spindle.
struct ToolInWorkpiece {
  Eigen::Vector3d tip_w_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_w = Eigen::Vector3d::UnitZ();
};

/// Actual workpiece side   r_from_w = (workpiece effects) PROD (E_j turn_j), bed outward,
/// actual tool side        r_from_t = (tool effects) T(gauge point) PROD (E_j turn_j) T(0, 0, -length),
/// with E_j the joint's error_transform about its error point and turn_j the exact rotation by command + joint effects.
struct VirtualMachine {
  std::vector<RotaryAxis> workpiece_axes;  ///< from the bed outward
  std::vector<RotaryAxis> tool_axes;       ///< from the bed outward
  std::vector<RigidEffect>
      workpiece_effects;                  ///< motions of the table in R, applied from the left, the last one leftmost
  std::vector<RigidEffect> tool_effects;  ///< motions of the tool in R, likewise
  std::vector<std::pair<char, JointEffect>> joint_effects;  ///< rad added to what an axis is told
  std::vector<ArtifactEffect> artifact_effects;             ///< motions of the touched face in W
  std::vector<ReadingEffect> reading_effects;               ///< mm added to the contact point along the approach
  double ball_radius_mm = 0;

  RotaryAxis& axis(char name);
  const RotaryAxis& axis(char name) const;

  Eigen::Isometry3d r_from_w(const MachineState& state) const;
  Eigen::Isometry3d r_from_w_nominal(const RotaryPosition& rotary) const;
  Eigen::Isometry3d r_from_tool(const MachineState& state) const;
  Eigen::Isometry3d r_from_tool_nominal(const MachineState& state) const;

  /// r_from_tool, counted from the set-up at A = B = C = 0 with a tool of this length. Where the head's own errors put
  /// the tip b beside its place there, the workpiece was set up b off and carries that along: the tip is moved by -R b,
  /// so that a constant b makes the deviation -(I - R) b. The tilt that the tool had against the workpiece there is
  /// undone likewise, in W. The same as r_from_tool where the tool side has no rotary errors at A = B = C = 0.
  Eigen::Isometry3d r_from_tool_since_setup(const MachineState& state) const;

  /// T(Delta) = T(A,C) T(0,0)^-1 T~(A,C)^-1 of the workpiece side, the reference being the default MachineState; and
  /// its six numbers at R's origin.
  Eigen::Isometry3d table_error(const MachineState& state) const;
  AxisErrors pose_error(const RotaryPosition& rotary) const;

  /// Actual workpiece point minus actual tool tip, both nominally at state.tip_r_mm, the workpiece as set up at A = C =
  /// 0.
  Eigen::Vector3d deviation_mm(const MachineState& state) const;

  /// Where a touch is recorded, in nominal machine coordinates: the probe comes along the nominal inward normal through
  /// the nominal contact point and stops where its tip really meets the real face (ball radius compensated along the
  /// approach). `state` gives the rotary position and the covariates; the tip and its sense follow from the face. No
  /// noise.
  Eigen::Vector3d touch(const Face& face, MachineState state) const;
  Eigen::Vector3d nominal_contact_r_mm(const Face& face, const RotaryPosition& rotary) const;
  Eigen::Vector3d approach_r(const Face& face, const RotaryPosition& rotary) const;

  /// R-test: n . (actual ball - actual sensor) in mm; the sensor nominally at state.tip_r_mm, the ball really at
  /// `ball_w_mm`.
  double displacement_mm(const Eigen::Vector3d& ball_w_mm, const Eigen::Vector3d& n, const MachineState& state) const;

  /// The table's rotation error (rotation vector of T(Delta)) about `axis`, rad.
  double rotation_rad(const Eigen::Vector3d& axis, const MachineState& state) const;

  /// A target on the table as an instrument standing in R sees it.
  Eigen::Isometry3d pose(const Eigen::Isometry3d& instrument_from_r, const Eigen::Isometry3d& w_from_target,
                         const MachineState& state) const;

  /// The state in which a command puts the machine: the control solves its nominal kinematics.
  MachineState commanded_state(const Command& command) const;

  /// The tool seen from the workpiece, which was set up in R at A = C = 0 with everything else of the state at its
  /// default: (T(A,C) T(0,0)^-1)^-1 r_from_tool_since_setup.
  ToolInWorkpiece tool_in_workpiece(const MachineState& state) const;

  /// A program, command after command. Senses of motion follow from the commands; before the first motion they are
  /// those of the default state. Senses of X Y Z are those of the slides, not of the programmed words.
  std::vector<ToolInWorkpiece> play(const std::vector<Command>& program) const;
};

/// Part of the way between two commands, as a control interpolates: straight in what is programmed.
Command between(const Command& from, const Command& to, double fraction);

/// A machine without errors from its structure code, workpiece to tool, such as "w C' A' Y' b X Z t": axes A B C about
/// X Y Z through R's origin, in any order on either side. Throws std::invalid_argument for a code it cannot read, and
/// for a linear axis carried by a rotary one.
VirtualMachine perfect_machine(const std::string& structure);

}  // namespace trunnion::testing
