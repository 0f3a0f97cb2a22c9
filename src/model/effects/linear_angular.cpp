#include <algorithm>
#include <array>

#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// Which components of the lever from a slide's own origin to the cutting point change as the machine moves; what stays
/// constant in it belongs to scale, straightness and squareness. A workpiece-side slide is moved against the point by
/// itself and by all axes between it and the tool, so not by those that it carries towards the table. A tool-side slide
/// sees the tip move by the axes that it carries towards the tool.
std::array<bool, 3> moving_lever(const Structure& structure, char axis) {
  const auto slide = std::ranges::find(structure.joints, axis, &Joint::letter);
  const bool workpiece_side = slide->side == Side::workpiece;
  std::array<bool, 3> moving{workpiece_side, workpiece_side, workpiece_side};
  const auto flip = [&](auto first, auto last) {
    for (; first != last; ++first)
      if (first->letter >= 'X') moving[static_cast<std::size_t>(first->letter - 'X')] = !workpiece_side;
  };
  workpiece_side ? flip(structure.joints.begin(), slide) : flip(slide + 1, structure.joints.end());
  return moving;
}

/// Pitch, yaw or roll of a slide, theta = k q about e with q its coordinate, at the lever l (see moving_lever):
///   on the workpiece side  d = +theta e x l,  the table turned by +theta e,
///   on the tool side       d = -theta e x l,  the tool turned by it. Components of l that do not move are those of
/// the tool from its gauge point, r_from_t (0, 0, -length), so that the last slide has d = -theta e x r_tool.
Formula linear_angular(const std::string& detail, const EffectContext& context) {
  const bool known = detail.size() == 3 && detail[0] == 'E' && detail[1] >= 'A' && detail[1] <= 'C' &&
                     detail[2] >= 'X' && detail[2] <= 'Z';
  if (!known) refuse_detail("linear_angular", detail, "one of EAX, EBX, ECX, EAY, EBY, ECY, EAZ, EBZ, ECZ");
  const Eigen::Vector3d e = Eigen::Vector3d::Unit(detail[1] - 'A');
  const Eigen::Index along = detail[2] - 'X';
  const std::array<bool, 3> moving = moving_lever(context.structure, detail[2]);
  const bool workpiece_side =
      std::ranges::find(context.structure.joints, detail[2], &Joint::letter)->side == Side::workpiece;
  return {
      .id = "linear_angular:" + detail,
      .moves_table = workpiece_side,
      .depends_on = {"x_mm", "y_mm", "z_mm"},
      .parameters = {{detail, Unit::urad_per_m}},
      .basis =
          [=, chain = context.chain](const Situation& s, const Eigen::VectorXd&) {
            Eigen::Vector3d tool = Eigen::Vector3d::Zero();
            if (!workpiece_side) tool = chain->r_from_t(s.at) * Eigen::Vector3d(0, 0, -s.tool_length_mm);
            Eigen::Vector3d lever;
            for (Eigen::Index k = 0; k < 3; ++k)
              lever[k] = moving[static_cast<std::size_t>(k)] ? s.point_r_mm[k] : tool[k];
            const double theta = (workpiece_side ? 1 : -1) * s.point_r_mm[along];
            Matrix6Xd b(6, 1);
            b << theta * e.cross(lever - s.point_r_mm), theta * e;  // a twist at R's origin: d = D + theta x p
            return b;
          },
  };
}

}  // namespace

Family linear_angular_family() {
  return {
      .name = "linear_angular",
      .what = "a slide pitches, yaws or rolls as it travels",
      .remedy = "an autocollimator or level along the axis; probing with a second stylus length and at other heights",
      .absurd = from_unit(2000, Unit::urad_per_m),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            for (const char axis : {'X', 'Y', 'Z'})
              for (const char about : {'A', 'B', 'C'})
                found.push_back(make_effect(linear_angular({'E', about, axis}, scope.context)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        return make_effect(linear_angular(detail, context), json);
      },
  };
}

}  // namespace trunnion
