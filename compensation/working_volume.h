#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinematics/machine.h"
#include "model/model.h"

namespace trunnion {

/// The volume that tables are made for and judged over: rotary commands, and points of R that the tool tip reaches.
struct WorkingVolume {
  Range<Angle> a{};
  Range<Angle> c{};
  Range<Length> x{}, y{}, z{};
  Length tool_length;  ///< of the tool that the tables assume where their argument is the Z axis and not the tip

  Eigen::Vector3d centre_mm() const;
  /// Variance of each coordinate over the volume, mm^2.
  Eigen::Vector3d variance_mm2() const;
};

/// [work_volume] of the machine file with its defaults (CONTRACT): A the part of the axis' range that was probed, C a
/// full turn, X Y Z +-150 mm about R's origin cut to the strokes. Throws RangeError where it asks for a tilt that was
/// not probed, ModelError where nothing is left of it.
WorkingVolume working_volume(const Machine& machine, const Model& model);

/// A (and C) of the reference pose, in degrees: 0, if the volume's tilts reach it.
std::optional<double> reference_deg(const WorkingVolume& volume);

/// `count` situations spread evenly over the volume by Halton's sequence from its element `first` on (J. H. Halton,
/// 1960; bases 2, 3, 5, 7, 11), with both senses of the last motion of A and of C where the model needs them.
std::vector<Situation> pose_sample(const WorkingVolume& volume, const Model& model, std::size_t count,
                                   std::size_t first);

/// Whether an effect of the machine depends on `column`, e.g. A_dir.
bool depends_on(const Model& model, const std::string& column);

}  // namespace trunnion
