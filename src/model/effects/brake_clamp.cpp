#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"
#include "model/joint_motion.h"

namespace trunnion {
namespace {

/// A rotary axis that turns by a step when its brake closes: step x flag, the flag a column of the data (0 open, 1
/// clamped).
Formula brake_clamp(const std::string& detail, const std::string& column, const EffectContext& context) {
  if (detail.size() != 1 || (detail[0] != 'C' && detail[0] != context.tilt_letter))
    refuse_detail("brake_clamp", detail, "a rotary axis of the machine");
  const std::size_t index = detail[0] == 'C' ? context.chain->turn_index() : context.chain->tilt_index();
  return {
      .id = "brake_clamp:" + detail,
      .moves_table = context.chain->rotary_joints()[index].side == Side::workpiece,
      .depends_on = {column},
      .parameters = {{"step", Unit::urad}},
      .keys = {{"column", column}},
      .basis =
          [index, column, chain = context.chain](const Situation& s, const Eigen::VectorXd&) {
            Matrix6Xd b(6, 1);
            b = beyond_zero(s, column) * joint_rotation(*chain, index, s);
            return b;
          },
  };
}

/// A flag that starts with an axis letter and an underscore is that axis'; any other may be either's.
bool may_be_flag_of(const std::string& column, char axis) {
  const bool lettered = column.size() > 1 && column[1] == '_' && column[0] >= 'A' && column[0] <= 'C';
  return !lettered || column[0] == axis;
}

}  // namespace

Family brake_clamp_family() {
  return {
      .name = "brake_clamp",
      .what = "a rotary axis turns a little when its brake closes",
      .remedy = "the same poses with the brake open and closed, with a column such as A_clamped (0 or 1)",
      .absurd = from_unit(200, Unit::urad),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            for (const std::string& column : columns_named(scope, {"clamp", "brake"}))
              for (const char axis : {scope.context.tilt_letter, 'C'})
                if (may_be_flag_of(column, axis))
                  found.push_back(make_effect(brake_clamp({axis}, column, scope.context)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        return make_effect(brake_clamp(detail, text_key(json, "column", "brake_clamp:" + detail), context), json);
      },
  };
}

}  // namespace trunnion
