#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

constexpr const char* kSymbols[] = {"EYX", "EZX", "EXY", "EZY", "EXZ", "EYZ"};

/// EYX of X (EZX, EXY …) bending as q x^2 + c x^3: d_y = -(q x^2 + c x^3). What is constant or linear in x belongs to
/// the pose and to squareness. A translation acts alike whichever side carries the axis.
Formula straightness(const std::string& detail) {
  for (const char* symbol : kSymbols) {
    if (detail != symbol) continue;
    const Eigen::Index moved = detail[1] - 'X', along = detail[2] - 'X';
    return {
        .id = "straightness:" + detail,
        .depends_on = {std::string(1, static_cast<char>('x' + along)) + "_mm"},
        .parameters = {{"quadratic", Unit::um_per_m2, 0, from_unit(5000, Unit::um_per_m2)},
                       {"cubic", Unit::um_per_m3, 0, from_unit(30000, Unit::um_per_m3)}},
        .basis =
            [moved, along](const Situation& s, const Eigen::VectorXd&) {
              Matrix6Xd b = Matrix6Xd::Zero(6, 2);
              const double x = s.point_r_mm[along];
              b(moved, 0) = -x * x;
              b(moved, 1) = -x * x * x;
              return b;
            },
    };
  }
  refuse_detail("straightness", detail, "one of EYX, EZX, EXY, EZY, EXZ, EYZ");
}

}  // namespace

Family straightness_family() {
  return {
      .name = "straightness",
      .what = "a linear axis runs along a curve",
      .remedy = "a straightedge or a laser along the axis; probing spots at four or more places along it",
      .candidates =
          [](const CandidateScope&) {
            std::vector<EffectPtr> found;
            for (const char* symbol : kSymbols) found.push_back(make_effect(straightness(symbol)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(straightness(detail), json);
      },
  };
}

}  // namespace trunnion
