#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "support/noise.h"
#include "support/observation_row.h"
#include "support/virtual_machine.h"

namespace trunnion::testing {

/// Square columns on the table, each touched on its four sides and on top. Points are labelled column, S or T, number:
/// S1 looks to +X, S2 to -X, S3 to +Y, S4 to -Y.
struct Columns {
  std::vector<Eigen::Vector2d> centres_w_mm = {{-90, -90}, {90, -90}, {-90, 90}};
  double half_width_mm = 20;
  std::vector<double> side_z_mm = {100};
  std::vector<Eigen::Vector2d> top_offsets_mm = {{0, 0}};
  double top_z_mm = 110;
};
std::vector<Face> faces_of(const Columns& columns);

/// The same faces where they really are: off by up to +-offset along their normals, tilted by up to +-tilt.
std::vector<Face> as_built(std::vector<Face> faces, Noise& noise, double offset_mm, double tilt_rad);

struct PlannedTouch {
  std::size_t face = 0;
  double A_deg = 0;  ///< of the tilting axis, A or B
  double C_deg = 0;
  int repeat = 0;
  double time_s = 0;
  int A_dir = -1;
  int C_dir = 1;
  int order = 0;
  int order_in_pose = 0;
  double temperature_C = 20;
  double tool_length_mm = 0;  ///< of the probe: the lever of tool-side angular errors
  std::map<std::string, double> covariates;
};

struct ProbingPlan {
  std::vector<Face> faces;
  std::vector<PlannedTouch> touches;
};

/// Faces whose outward normal, as the table stands, has z > -0.05: touched from above or from the side.
std::vector<std::size_t> reachable(const VirtualMachine& machine, const std::vector<Face>& faces, double A_deg,
                                   double C_deg);

/// `count` of the reachable faces that determine the six pose errors best: greedy, then exchanges, by the determinant
/// of sum g g^T with g = (n, p x n / 100 mm). All of them where there are fewer.
std::vector<std::size_t> d_optimal(const VirtualMachine& machine, const std::vector<Face>& faces, double A_deg,
                                   double C_deg, std::size_t count);

/// How long things take; the first touch is after one pose and one touch.
struct Pace {
  double pose_s = 6;
  double touch_s = 7;
  double start_s = 0;
  int first_order = 0;
  int A_dir = -1;  ///< senses in which the axes came to the first pose
  int C_dir = 1;
};
/// Times, orders and senses of motion (those of the last motion of each axis) from the succession of the touches.
ProbingPlan timed(ProbingPlan plan, const Pace& pace = {});

/// 219 touches of 15 spots: all at A = C = 0, then A = 0, -30, -60, -90 by C = 0, 60 ... 300, nine touches each, eight
/// at A = -90, C = 60, 180, 300.
ProbingPlan replica_plan();

/// 294 touches of 18 spots, each column with two on top: all at A = C = 0, twelve at each other pose.
ProbingPlan two_top_plan(std::size_t touches_per_pose = 12);

/// Three passes of a plan: as it stands; everything reversed; poses with A rising, C rising in each row.
ProbingPlan three_passes(const ProbingPlan& plan, const Pace& pace = {});

/// The reference pose, all spots, then `poses` positions off any grid: one in each of `poses` equal stretches of A from
/// `A_low_deg` to 0, in random order, C anywhere, up to `touches_per_pose` each.
struct VerificationOptions {
  std::uint64_t seed = 1;
  std::size_t poses = 24;
  std::size_t touches_per_pose = 12;
  double A_low_deg = -85;
};
ProbingPlan verification_plan(const std::vector<Face>& faces, const VerificationOptions& options,
                              const Pace& pace = {});

/// What a touch adds: normal (or Student's t) noise along the approach, and now and then a chip in between.
struct TouchNoise {
  double sigma_mm = 0;
  int student_freedom = 0;  ///< 0: normal
  double chip_rate = 0;
  double chip_min_mm = 2e-3;
  double chip_max_mm = 20e-3;
};

/// Performs the plan. Chips stop the probe early: they add to the contact point against the approach.
std::vector<ObservationRow> probe(const VirtualMachine& machine, const ProbingPlan& plan, const TouchNoise& touch_noise,
                                  Noise& noise);

/// The machine's state of a planned touch, the tip left to the touch.
MachineState state_of(const VirtualMachine& machine, const PlannedTouch& touch);

/// R-test: the ball nominally stands at `ball_w_mm`, really `placed_mm` beside it.
ObservationRow displacement_row(const VirtualMachine& machine, const PlannedTouch& where, const std::string& point,
                                const Eigen::Vector3d& ball_w_mm, const Eigen::Vector3d& placed_mm,
                                const Eigen::Vector3d& n, double noise_mm = 0);
/// Encoder or autocollimator of unknown zero.
ObservationRow rotation_row(const VirtualMachine& machine, const PlannedTouch& where, const std::string& artifact,
                            const Eigen::Vector3d& axis, double zero_rad, double noise_rad = 0);
/// A target seen by an instrument; noise is a small motion of the target in the instrument's frame, at the target.
ObservationRow pose_row(const VirtualMachine& machine, const PlannedTouch& where, const std::string& artifact,
                        const Eigen::Isometry3d& instrument_from_r, const Eigen::Isometry3d& w_from_target,
                        const AxisErrors& noise = {});

}  // namespace trunnion::testing
