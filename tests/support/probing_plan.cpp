#include "support/probing_plan.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace trunnion::testing {
namespace {

using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kLever_mm = 100;    // makes rotations comparable to translations
constexpr double kSteepest = -0.05;  // of the outward normal's z: a face that overhangs more is not reached

bool has_axis(const VirtualMachine& machine, char name) {
  const auto named = [name](const RotaryAxis& axis) { return axis.name == name; };
  return std::any_of(machine.workpiece_axes.begin(), machine.workpiece_axes.end(), named) ||
         std::any_of(machine.tool_axes.begin(), machine.tool_axes.end(), named);
}

RotaryPosition position_of(const VirtualMachine& machine, double tilt_deg, double C_deg) {
  return has_axis(machine, 'B') ? bc_degrees(tilt_deg, C_deg) : ac_degrees(tilt_deg, C_deg);
}

double determinant(const std::vector<Vector6>& rows, const std::vector<std::size_t>& chosen) {
  Matrix6 information = 1e-9 * Matrix6::Identity();
  for (std::size_t i : chosen) information += rows[i] * rows[i].transpose();
  return information.determinant();
}

/// All faces at A = C = 0, then the chosen ones at the poses of the grid.
ProbingPlan grid_plan(const Columns& columns, const std::function<std::size_t(double, double)>& touches_at) {
  const VirtualMachine machine = perfect_machine("w C' A' Y' b X Z t");
  ProbingPlan plan{faces_of(columns), {}};
  for (double A_deg : {0., -30., -60., -90.})
    for (double C_deg : {0., 60., 120., 180., 240., 300.}) {
      std::vector<std::size_t> chosen(plan.faces.size());
      std::iota(chosen.begin(), chosen.end(), 0U);
      if (A_deg != 0 || C_deg != 0) chosen = d_optimal(machine, plan.faces, A_deg, C_deg, touches_at(A_deg, C_deg));
      for (std::size_t face : chosen) plan.touches.push_back({.face = face, .A_deg = A_deg, .C_deg = C_deg});
    }
  return timed(plan);
}

int sense(double moved, int before) { return moved > 0 ? 1 : moved < 0 ? -1 : before; }

ObservationRow row_at(const PlannedTouch& where) {
  ObservationRow row;
  row.A_deg = where.A_deg;
  row.C_deg = where.C_deg;
  row.repeat = where.repeat;
  row.time_s = where.time_s;
  row.A_dir = where.A_dir;
  row.C_dir = where.C_dir;
  row.temperature_C = where.temperature_C;
  row.covariates = where.covariates;
  return row;
}

}  // namespace

std::vector<Face> faces_of(const Columns& columns) {
  std::vector<Face> faces;
  for (std::size_t k = 0; k < columns.centres_w_mm.size(); ++k) {
    const std::string artifact = std::to_string(k + 1);
    const Vector3d centre(columns.centres_w_mm[k].x(), columns.centres_w_mm[k].y(), 0);
    const auto add = [&](char kind, int number, const Vector3d& point, const Vector3d& outward) {
      const std::string label = artifact + kind + std::to_string(number);
      faces.push_back({label, artifact, point, outward, point, outward});
    };
    int side = 0;
    for (double z : columns.side_z_mm)
      for (const Vector3d& outward : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, -1, 0)})
        add('S', ++side, centre + columns.half_width_mm * outward + z * Vector3d::UnitZ(), outward);
    int top = 0;
    for (const Eigen::Vector2d& offset : columns.top_offsets_mm)
      add('T', ++top, centre + Vector3d(offset.x(), offset.y(), columns.top_z_mm), Vector3d::UnitZ());
  }
  return faces;
}

std::vector<Face> as_built(std::vector<Face> faces, Noise& noise, double offset_mm, double tilt_rad) {
  for (Face& face : faces) {
    face.actual_w_mm = face.nominal_w_mm + noise.uniform(-offset_mm, offset_mm) * face.nominal_outward_w;
    const double a = noise.uniform(-tilt_rad, tilt_rad);
    const double b = noise.uniform(-tilt_rad, tilt_rad);
    const Vector3d along = face.nominal_outward_w.unitOrthogonal();
    const Vector3d across = face.nominal_outward_w.cross(along);
    face.actual_outward_w = (face.nominal_outward_w + std::tan(a) * along + std::tan(b) * across).normalized();
  }
  return faces;
}

std::vector<std::size_t> reachable(const VirtualMachine& machine, const std::vector<Face>& faces, double A_deg,
                                   double C_deg) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (-machine.approach_r(faces[i], position_of(machine, A_deg, C_deg)).z() > kSteepest) found.push_back(i);
  return found;
}

std::vector<std::size_t> d_optimal(const VirtualMachine& machine, const std::vector<Face>& faces, double A_deg,
                                   double C_deg, std::size_t count) {
  const RotaryPosition position = position_of(machine, A_deg, C_deg);
  std::vector<Vector6> rows;
  for (const Face& face : faces) {
    const Vector3d n = machine.approach_r(face, position);
    const Vector3d p = machine.nominal_contact_r_mm(face, position);
    rows.push_back((Vector6() << n, p.cross(n) / kLever_mm).finished());
  }
  std::vector<std::size_t> left = reachable(machine, faces, A_deg, C_deg);
  std::vector<std::size_t> chosen;
  // Ties within rounding go to the face that stands first, so that the choice is the same everywhere.
  constexpr double kClearly = 1 + 1e-6;
  while (chosen.size() < count && !left.empty()) {
    std::size_t best = 0;
    double best_determinant = 0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      chosen.push_back(left[i]);
      const double d = determinant(rows, chosen);
      chosen.pop_back();
      if (d > best_determinant * kClearly) std::tie(best, best_determinant) = std::pair(i, d);
    }
    chosen.push_back(left[best]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  for (bool improved = true; improved;) {
    improved = false;
    for (std::size_t& inside : chosen)
      for (std::size_t& outside : left) {
        const double before = determinant(rows, chosen);
        std::swap(inside, outside);
        if (determinant(rows, chosen) > before * kClearly)
          improved = true;
        else
          std::swap(inside, outside);
      }
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

ProbingPlan timed(ProbingPlan plan, const Pace& pace) {
  double time_s = pace.start_s;
  int A_dir = pace.A_dir, C_dir = pace.C_dir, order_in_pose = 0;
  for (std::size_t i = 0; i < plan.touches.size(); ++i) {
    PlannedTouch& touch = plan.touches[i];
    const PlannedTouch* before = i ? &plan.touches[i - 1] : nullptr;
    const bool moved = !before || touch.A_deg != before->A_deg || touch.C_deg != before->C_deg;
    if (before) {
      A_dir = sense(touch.A_deg - before->A_deg, A_dir);
      C_dir = sense(touch.C_deg - before->C_deg, C_dir);
    }
    order_in_pose = moved ? 0 : order_in_pose + 1;
    time_s += pace.touch_s + (moved ? pace.pose_s : 0);
    touch.time_s = time_s;
    touch.A_dir = A_dir;
    touch.C_dir = C_dir;
    touch.order = pace.first_order + static_cast<int>(i);
    touch.order_in_pose = order_in_pose;
  }
  return plan;
}

ProbingPlan replica_plan() {
  return grid_plan({}, [](double A_deg, double C_deg) -> std::size_t {
    return A_deg == -90 && (C_deg == 60 || C_deg == 180 || C_deg == 300) ? 8 : 9;
  });
}

ProbingPlan two_top_plan(std::size_t touches_per_pose) {
  Columns columns;
  columns.top_offsets_mm = {{-12, 0}, {12, 8}};
  return grid_plan(columns, [touches_per_pose](double, double) { return touches_per_pose; });
}

ProbingPlan three_passes(const ProbingPlan& plan, const Pace& pace) {
  ProbingPlan all{plan.faces, plan.touches};
  const auto add = [&all](std::vector<PlannedTouch> touches, int repeat) {
    for (PlannedTouch& touch : touches) {
      touch.repeat = repeat;
      all.touches.push_back(touch);
    }
  };
  std::vector<PlannedTouch> rising(plan.touches);
  std::stable_sort(rising.begin(), rising.end(), [](const PlannedTouch& a, const PlannedTouch& b) {
    return std::pair(a.A_deg, a.C_deg) < std::pair(b.A_deg, b.C_deg);
  });
  add({plan.touches.rbegin(), plan.touches.rend()}, 1);
  add(rising, 2);
  return timed(all, pace);
}

ProbingPlan verification_plan(const std::vector<Face>& faces, const VerificationOptions& options, const Pace& pace) {
  const VirtualMachine machine = perfect_machine("w C' A' Y' b X Z t");
  Noise noise(options.seed);
  std::vector<double> tilts;
  for (std::size_t i = 0; i < options.poses; ++i)
    tilts.push_back(options.A_low_deg * (static_cast<double>(i) + noise.uniform()) /
                    static_cast<double>(options.poses));
  for (std::size_t i = tilts.size(); i > 1; --i) std::swap(tilts[i - 1], tilts[noise.below(i)]);

  ProbingPlan plan{faces, {}};
  for (std::size_t face = 0; face < faces.size(); ++face) plan.touches.push_back({.face = face});
  for (double tilt : tilts) {
    const double A_deg = std::round(tilt * 1e3) / 1e3;
    const double C_deg = std::round(noise.uniform(0, 360) * 1e3) / 1e3;
    for (std::size_t face : d_optimal(machine, faces, A_deg, C_deg, options.touches_per_pose))
      plan.touches.push_back({.face = face, .A_deg = A_deg, .C_deg = C_deg});
  }
  return timed(plan, pace);
}

MachineState state_of(const VirtualMachine& machine, const PlannedTouch& touch) {
  MachineState state;
  state.rotary = position_of(machine, touch.A_deg, touch.C_deg);
  const double tilt_dir = touch.A_dir, C_dir = touch.C_dir;
  state.rotary_sense = {tilt_dir, tilt_dir, C_dir};
  state.tool_length_mm = touch.tool_length_mm;
  state.time_s = touch.time_s;
  state.temperature_C = touch.temperature_C;
  state.order = touch.order;
  state.order_in_pose = touch.order_in_pose;
  state.repeat = touch.repeat;
  state.covariates = touch.covariates;
  return state;
}

std::vector<ObservationRow> probe(const VirtualMachine& machine, const ProbingPlan& plan, const TouchNoise& touch_noise,
                                  Noise& noise) {
  std::vector<ObservationRow> rows;
  for (const PlannedTouch& touch : plan.touches) {
    const Face& face = plan.faces[touch.face];
    const MachineState state = state_of(machine, touch);
    const Vector3d n = machine.approach_r(face, state.rotary);
    const double unit = touch_noise.student_freedom ? noise.student_t(touch_noise.student_freedom) : noise.normal();
    double along_mm = touch_noise.sigma_mm * unit;
    if (touch_noise.chip_rate > 0 && noise.uniform() < touch_noise.chip_rate)
      along_mm -= noise.uniform(touch_noise.chip_min_mm, touch_noise.chip_max_mm);
    ObservationRow row = row_at(touch);
    row.point = face.point;
    row.artifact = face.artifact;
    row.xyz_mm = machine.touch(face, state) + along_mm * n;
    row.n = n;
    rows.push_back(row);
  }
  return rows;
}

ObservationRow displacement_row(const VirtualMachine& machine, const PlannedTouch& where, const std::string& point,
                                const Vector3d& ball_w_mm, const Vector3d& placed_mm, const Vector3d& n,
                                double noise_mm) {
  MachineState state = state_of(machine, where);
  state.tip_r_mm = machine.r_from_w_nominal(state.rotary) * ball_w_mm;
  ObservationRow row = row_at(where);
  row.kind = "displacement";
  row.point = point;
  row.xyz_mm = state.tip_r_mm;
  row.n = n;
  row.value_um = 1e3 * (machine.displacement_mm(ball_w_mm + placed_mm, n, state) + noise_mm);
  return row;
}

ObservationRow rotation_row(const VirtualMachine& machine, const PlannedTouch& where, const std::string& artifact,
                            const Vector3d& axis, double zero_rad, double noise_rad) {
  ObservationRow row = row_at(where);
  row.kind = "rotation";
  row.artifact = artifact;
  row.m = axis;
  row.value_urad = 1e6 * (machine.rotation_rad(axis, state_of(machine, where)) + zero_rad + noise_rad);
  return row;
}

ObservationRow pose_row(const VirtualMachine& machine, const PlannedTouch& where, const std::string& artifact,
                        const Eigen::Isometry3d& instrument_from_r, const Eigen::Isometry3d& w_from_target,
                        const AxisErrors& noise) {
  const Eigen::Isometry3d seen = machine.pose(instrument_from_r, w_from_target, state_of(machine, where));
  const Eigen::Quaterniond q(error_transform(noise).linear() * seen.linear());
  ObservationRow row = row_at(where);
  row.kind = "pose";
  row.artifact = artifact;
  row.xyz_mm = seen.translation() + noise.translation_mm;
  row.quaternion_wxyz = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
  return row;
}

}  // namespace trunnion::testing
