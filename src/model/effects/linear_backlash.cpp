#include <algorithm>

#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// Lost motion b of a linear axis: it lags by b / 2 in the sense of its last motion, d_x = +(b / 2) sense, so that a
/// touch reads (b / 2) |n_x|. Zero where the sense is not known.
Formula linear_backlash(const std::string& detail) {
  if (detail != "X" && detail != "Y" && detail != "Z") refuse_detail("linear_backlash", detail, "an axis X, Y or Z");
  const Eigen::Index axis = detail[0] - 'X';
  return {
      .id = "linear_backlash:" + detail,
      .depends_on = {detail + "_dir"},
      .parameters = {{"reversal", Unit::um}},
      .basis =
          [axis](const Situation& s, const Eigen::VectorXd&) {
            Matrix6Xd b = Matrix6Xd::Zero(6, 1);
            b(axis, 0) = s.linear_sense[axis] / 2;
            return b;
          },
  };
}

}  // namespace

Family linear_backlash_family() {
  return {
      .name = "linear_backlash",
      .what = "a linear axis stops elsewhere when it comes from the other side",
      .remedy = "touches approached after overshooting the spot from the far side",
      .absurd = from_unit(100, Unit::um),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            for (const char axis : {'X', 'Y', 'Z'}) {
              const auto moved = [axis](const Situation& s) { return s.linear_sense[axis - 'X'] != 0; };
              if (std::ranges::any_of(scope.readings, moved)) found.push_back(make_effect(linear_backlash({axis})));
            }
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(linear_backlash(detail), json);
      },
  };
}

}  // namespace trunnion
