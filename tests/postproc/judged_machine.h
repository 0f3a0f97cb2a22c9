#pragma once

#include <cmath>
#include <string>

#include "geometric_errors/rotary_errors.h"
#include "postproc/correction.h"
#include "support/virtual_machine.h"

// A machine with known errors, once as the program sees it and once as the virtual machine that judges.

namespace trunnion {

/// Smooth errors of 10-30 um and 20-60 urad, not zero at the reference.
inline testing::AxisErrors tilt_errors(const testing::RotaryPosition& q) {
  const double a = q.A_rad + q.B_rad;
  return testing::um_urad(8 + 5 * a, -12 + 9 * a * a, 6 * std::sin(a), 35 * std::sin(a), -20 + 15 * a,
                          10 * std::cos(a));
}
inline testing::AxisErrors turn_errors(const testing::RotaryPosition& q) {
  const double a = q.A_rad + q.B_rad, c = q.C_rad;
  return testing::um_urad(9 * std::cos(c), 7 * std::sin(c + a), 4 * std::cos(2 * c), 30 * std::sin(c),
                          25 * std::cos(2 * c + a), 15 * std::sin(c));
}

struct Judged {
  Machine machine;
  testing::VirtualMachine truth;
};

inline Judged judged(const std::string& code) {
  Judged both;
  both.machine.structure = parse_structure(code);
  both.machine.axes = default_axes(both.machine.structure);
  both.truth = testing::perfect_machine(code);
  both.truth.axis(both.machine.tilt_letter()).errors = tilt_errors;
  both.truth.axis('C').errors = turn_errors;
  return both;
}

inline testing::RotaryPosition rotary(const Machine& machine, IndexedPosition at) {
  testing::RotaryPosition q;
  (machine.tilt_letter() == 'A' ? q.A_rad : q.B_rad) = at.a.in_radians();
  q.C_rad = at.c.in_radians();
  return q;
}

/// The virtual machine's own errors, through the composition that the program uses.
class TrueField : public ErrorField {
 public:
  explicit TrueField(const Judged& judged, double scale = 1)
      : machine_(judged.machine), chain_(judged.machine), scale_(scale) {}
  PoseError at(const Situation& situation) const override {
    PoseError error = relative_pose_error(chain_, situation.at, errors(situation.at), errors({}),
                                          {situation.point_r_mm, situation.tool_length_mm});
    if (situation.turn_sense < 0) error.rotation_rad.z() += turn_reversal_rad;
    error.translation_mm += 0.5 * slide_reversal_mm * situation.linear_sense;
    error.translation_mm.z() += drift_mm_per_s * situation.time_s;
    return error;
  }
  double turn_reversal_rad = 0;  ///< what C is behind by after a motion in the negative sense
  double slide_reversal_mm = 0;  ///< of X, Y and Z, half to either side
  double drift_mm_per_s = 0;     ///< of the table, along Z
  Range<Angle> tilt_range() const override { return {Angle::degrees(-120), Angle::degrees(120)}; }

 private:
  RotaryErrors errors(IndexedPosition at) const {
    const testing::RotaryPosition q = rotary(machine_, at);
    const auto plain = [&](const testing::AxisErrors& e) {
      return scale_ * PoseError{e.translation_mm, e.rotation_rad};
    };
    return {plain(tilt_errors(q)), plain(turn_errors(q))};
  }
  const Machine& machine_;
  KinematicChain chain_;
  double scale_;
};

inline testing::Command command(const Machine& machine, const Commanded& at, ToolCentrePoint tcp, double length_mm) {
  testing::Command c;
  c.xyz_mm = at.xyz_mm;
  c.rotary = rotary(machine, at.rotary);
  c.tool_length_mm = length_mm;
  c.tcp = tcp == ToolCentrePoint::on ? testing::Tcp::on : testing::Tcp::off;
  return c;
}

inline Commanded corrected(const Corrector& corrector, const Commanded& programmed) {
  const RotaryCorrection turn = corrector.rotary(programmed);
  Commanded to = programmed;
  to.rotary = {programmed.rotary.a + turn.da, programmed.rotary.c + turn.dc};
  to.xyz_mm += corrector.linear(programmed, to.rotary).change_mm;
  return to;
}

struct Miss {
  double tip_mm;
  double axis_rad;
};

/// What the virtual machine, nonlinear and exact, makes of `commanded` against the perfect one at `programmed`.
inline Miss miss(const Judged& both, const Commanded& programmed, const Commanded& commanded,
                 const CorrectionSettings& settings) {
  const testing::VirtualMachine perfect = testing::perfect_machine(both.machine.structure.code);
  const auto wanted = perfect.tool_in_workpiece(
      perfect.commanded_state(command(both.machine, programmed, settings.tcp, settings.tool_length_mm)));
  const auto got = both.truth.tool_in_workpiece(
      both.truth.commanded_state(command(both.machine, commanded, settings.tcp, settings.tool_length_mm)));
  return {(wanted.tip_w_mm - got.tip_w_mm).norm(), wanted.axis_w.cross(got.axis_w).norm()};
}

}  // namespace trunnion
