#pragma once

#include <string>
#include <vector>

#include "kinematics/kinematic_chain.h"
#include "probing/observation.h"

namespace trunnion {

/// A spot of a face that can be touched, as it nominally stands in W.
struct Spot {
  std::string point, artifact;
  Eigen::Vector3d place_w_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d outward_w = Eigen::Vector3d::Zero();  ///< unit normal out of the face
};

/// Three square columns of 40 mm on the table, 90 mm out, each with its four sides at a height of 100 mm and two places
/// on top at 110 mm: eighteen spots, as many as tell the probe from the machine.
std::vector<Spot> column_spots();
/// The spots that were touched, where they nominally stand: means of what the commands of each touch say.
std::vector<Spot> spots_of(const ObservationSet& observations, const KinematicChain& chain);

/// A visit to an indexed position: its touches, and from which side the rotary axes come to it.
struct Visit {
  IndexedPosition at;
  std::vector<std::size_t> spots;      ///< in the order of the touches
  int repeat = 0;                      ///< pass
  int tilt_sense = 0, turn_sense = 0;  ///< 0: as the way from the position before brings it
};

/// What probing takes, and may take.
struct PlanOptions {
  double pose_s = 6, touch_s = 7;  ///< what a change of position and a touch take
  double start_s = 0;
  std::size_t touches = 12;   ///< at a position, at most
  Angle tilt_low, tilt_high;  ///< what is to be measured; both zero: -90 deg to 0 within the axis' stroke
};
/// The tilts that a plan covers, by the options, the work volume and the stroke of the axis.
Range<Angle> planned_tilts(const Machine& machine, const PlanOptions& options);

/// Beside a face, where the probe may come down before it touches.
constexpr double kLargestStandoff_mm = 8;

/// Spots that the probe can touch at a position: the face looks no more than 3 deg away from the tool, no other
/// artifact stands in the way of a probe that comes down along the tool's axis, and the linear axes reach it. An
/// artifact is known by its spots alone: their box, and what is below it.
std::vector<std::size_t> reachable(const Machine& machine, const KinematicChain& chain, const std::vector<Spot>& spots,
                                   IndexedPosition at);
/// At most `count` of them: those that determine the six pose errors best (D-optimal by exchange).
std::vector<std::size_t> best_spots(const Machine& machine, const KinematicChain& chain, const std::vector<Spot>& spots,
                                    IndexedPosition at, std::size_t count);

/// A calibration from nothing: all spots at the reference pose first, between the passes and last; four tilts by six
/// turns; the same backwards, which tells drift and backlash from the maps; then four positions off that grid.
std::vector<Visit> first_plan(const Machine& machine, const std::vector<Spot>& spots, const PlanOptions& options);

/// The readings that a plan would give on a machine without errors: places, senses of motion and times filled in.
/// `name` stands for the file. The rows are what a plan file holds.
ObservationSet planned_observations(const Machine& machine, const std::vector<Spot>& spots,
                                    const std::vector<Visit>& visits, const PlanOptions& options,
                                    const std::string& name);

}  // namespace trunnion
