#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// Two linear axes are not square; zero at R's origin, no rotation of anything:
///   XY: d_x = -EC0Y y,   XZ: d_x = -EB0Z z,   YZ: d_y = +EA0Z z.
/// Which of the two axes is called the straight one is convention: the other choice differs by a turn of the frame.
struct Plane {
  const char* name;
  const char* symbol;
  Eigen::Index moved;
  Eigen::Index along;
  double sign;
};
constexpr Plane kPlanes[] = {{"XY", "EC0Y", 0, 1, -1}, {"XZ", "EB0Z", 0, 2, -1}, {"YZ", "EA0Z", 1, 2, 1}};

Formula squareness(const std::string& detail) {
  for (const Plane& plane : kPlanes)
    if (detail == plane.name)
      return {
          .id = "squareness:" + detail,
          .depends_on = {plane.along == 1 ? "y_mm" : "z_mm"},
          .parameters = {{plane.symbol, Unit::urad}},
          .basis =
              [plane](const Situation& s, const Eigen::VectorXd&) {
                Matrix6Xd b = Matrix6Xd::Zero(6, 1);
                b(plane.moved, 0) = plane.sign * s.point_r_mm[plane.along];
                return b;
              },
      };
  refuse_detail("squareness", detail, "a plane XY, XZ or YZ");
}

}  // namespace

Family squareness_family() {
  return {
      .name = "squareness",
      .what = "two linear axes are not at right angles",
      .remedy = "a granite square, or a ball-bar in the plane of the two axes; probing spots spread over that plane",
      .absurd = from_unit(500, Unit::urad),
      .candidates =
          [](const CandidateScope&) {
            std::vector<EffectPtr> found;
            for (const Plane& plane : kPlanes) found.push_back(make_effect(squareness(plane.name)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(squareness(detail), json);
      },
  };
}

}  // namespace trunnion
