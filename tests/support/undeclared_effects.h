#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

#include "support/virtual_machine.h"

// What a machine or its measurement may have beyond rotary error maps, each acting exactly. `d` is the deviation,
// workpiece minus tool, in R; the reading is n . d. Every effect is zero at time 0, 20 deg C, covariates 0, axes last
// moved positively, unless it says otherwise. For anything else push a function of your own into the machine's vectors.

namespace trunnion::testing {

// The machine: linear axes. The table carries Y in the seed machine; a translation acts alike from either side.

/// The axis moves (1 + scale) of what it is told: d_x = -scale x. Scale in mm/mm.
void add_linear_scale(VirtualMachine& machine, char axis, double scale);
/// `plane` "XY": d_x = -angle y. "XZ": d_x = -angle z. "YZ": d_y = +angle z.
void add_squareness(VirtualMachine& machine, const std::string& plane, double angle_rad);
/// `symbol` "EYX": d_y = -f(x) with f in mm; likewise EZX EXY EZY EXZ EYZ, and EXX EYY EZZ for any positioning error.
void add_straightness(VirtualMachine& machine, const std::string& symbol, std::function<double(double)> mm_at_mm);
/// `symbol` "ECY": the table turns by f(y) about `point_r_mm`, d = f e x (p - point): for the axis that carries the
/// table.
void add_table_angular(VirtualMachine& machine, const std::string& symbol, std::function<double(double)> rad_at_mm,
                       const Eigen::Vector3d& point_r_mm = Eigen::Vector3d::Zero());
/// `symbol` "EAX": the tool turns by f(x) about its gauge point, d = -f e x (0, 0, -tool length).
void add_tool_angular(VirtualMachine& machine, const std::string& symbol, std::function<double(double)> rad_at_mm);
/// d_x = -amplitude cos(2 pi x / period + phase).
void add_linear_periodic(VirtualMachine& machine, char axis, double amplitude_mm, double period_mm, double phase_rad);
/// The axis lags by half the width in its sense of motion: d_x = +width / 2 sign, a touch reads width / 2 |n_x|.
void add_linear_backlash(VirtualMachine& machine, char axis, double width_mm);

// The machine: rotary axes and what carries them.

/// The axis stands `width` short of its command when it last moved negatively: angle + width / 2 (sense - 1).
void add_rotary_backlash(VirtualMachine& machine, char axis, double width_rad);
/// Angle + a cos(n q) + b sin(n q).
void add_cyclic_error(VirtualMachine& machine, char axis, int cycles, double cos_rad, double sin_rad);
/// Angle + step where the covariate (such as "A_clamped") is 1.
void add_brake_clamp(VirtualMachine& machine, char axis, const std::string& covariate, double step_rad);
/// The table turns about X through R's origin by (constant + per_unit load) sin(A + phase); load from the covariate.
void add_payload_sag(VirtualMachine& machine, const std::string& covariate, double constant_rad, double rad_per_unit,
                     double phase_rad = 0);
/// The table moves by motion(time_s) against the tool: d = translation + rotation x p at R's origin.
void add_drift(VirtualMachine& machine, std::function<AxisErrors(double)> motion_at_s);
/// add_drift with end (1 - exp(-t / tau)).
void add_thermal_drift(VirtualMachine& machine, const AxisErrors& end, double time_constant_s);
/// The table moves by per_kelvin (temperature - 20).
void add_temperature(VirtualMachine& machine, const AxisErrors& per_kelvin);

// The measurement.

/// Reading + (1 - n_z^2) (a cos(k phi) + b sin(k phi)), phi = atan2(n_y, n_x).
void add_probe_lobing(VirtualMachine& machine, int lobes, double cos_mm, double sin_mm);
/// Reading + pretravel n_z^2.
void add_probe_pretravel(VirtualMachine& machine, double axial_mm);
/// Reading + n . g exp(-order / decay), order counted over all touches.
void add_first_touches(VirtualMachine& machine, const Eigen::Vector3d& start_mm, double decay_touches);
/// Reading + n . g times the touch's number in its pose.
void add_settling(VirtualMachine& machine, const Eigen::Vector3d& per_touch_mm);
/// Faces move by coefficient * kelvin(touch) * (q - fixed point) in W.
void add_artifact_expansion(VirtualMachine& machine, double per_kelvin,
                            std::function<double(const MachineState&)> kelvin,
                            const Eigen::Vector3d& fixed_w_mm = Eigen::Vector3d::Zero());
/// From touch number `from_order` on, the artifact's faces stand moved in W.
void add_artifact_slip(VirtualMachine& machine, const std::string& artifact, const AxisErrors& moved_w, int from_order);
/// The artifact's faces move in W by end (1 - exp(-t / tau)).
void add_artifact_creep(VirtualMachine& machine, const std::string& artifact, const Eigen::Vector3d& end_w_mm,
                        double time_constant_s);
/// d = shift in pass number `repeat`, in R.
void add_pass_shift(VirtualMachine& machine, int repeat, const Eigen::Vector3d& shift_r_mm);

}  // namespace trunnion::testing
