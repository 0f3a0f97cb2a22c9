#include "kinematics/machine.h"

namespace trunnion {

std::map<char, Axis> default_axes(const Structure& structure) {
  std::map<char, Axis> axes;
  for (const Joint& joint : structure.joints) {
    Axis axis{.letter = joint.letter};
    axis.direction = Eigen::Vector3d::Unit((joint.letter >= 'X' ? joint.letter - 'X' : joint.letter - 'A'));
    axis.modulo = joint.letter == 'C';
    axes.emplace(joint.letter, axis);
  }
  return axes;
}

}  // namespace trunnion
