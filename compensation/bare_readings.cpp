#include "compensation/bare_readings.h"

#include "error.h"

namespace trunnion {

ObservationSet bare_readings(ObservationSet set, const PlayedCompensation& played, const KinematicChain& chain) {
  const std::vector<Situation> commanded = situations(set);
  std::vector<AxisCorrection> added;
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    if (set.rows[i].kind == ReadingKind::surface)
      throw InputError(set.place(i),
                       "a point of a measured piece: what was switched on while it was cut is not known here");
    added.push_back(played.at(commanded[i]));
  }
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    Observation& o = set.rows[i];
    const IndexedPosition there{o.at.a + Angle::radians(added[i].tilt_rad), o.at.c + Angle::radians(added[i].turn_rad)};
    const Eigen::Isometry3d moved = chain.r_from_w(there) * chain.r_from_w(o.at).inverse();
    switch (o.kind) {
      case ReadingKind::contact:
        o.position_mm += added[i].linear_mm;
        break;
      case ReadingKind::displacement: {
        const Eigen::Vector3d ball = moved * o.position_mm;
        o.value += o.direction.dot(o.position_mm + added[i].linear_mm - ball);
        o.position_mm = ball;
        break;
      }
      case ReadingKind::rotation: {
        const Eigen::AngleAxisd turn(moved.linear());
        o.value -= turn.angle() * o.direction.dot(turn.axis());
        break;
      }
      default:
        break;
    }
    o.at = there;
  }
  return set;
}

}  // namespace trunnion
