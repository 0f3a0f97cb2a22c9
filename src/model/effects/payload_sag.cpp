#include <cmath>

#include "geometric_errors/rotary_errors.h"
#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"
#include "model/joint_motion.h"

namespace trunnion {
namespace {

/// Under a payload m the tilting axis gives way by the moment of its weight. With the load's centre of gravity at
/// height h and off centre by e in the tilting frame the moment goes as m (h sin A + e cos A), so the axis turns by
///   sag = m (s sin A + c cos A),   with ":unbalance" in addition  m cos A (p cos C + q sin C).
/// Relative to the reference pose, where the workpiece was set up under its own load (CONTRACT: zero there):
///   e = J_here sag(A, C) + J_reference sag(0, 0).
/// Readings of one file may be taken under several loads, but their spots are known from one of them; `seat` is how the
/// load turned the probed body itself about the tilting axis at the reference pose, carried along by the table. It
/// matters between readings only: set-up takes it out, so it is absent where nothing is read.
Formula payload_sag(const std::string& detail, const std::string& column, const EffectContext& context) {
  const bool unbalance = detail == "unbalance";
  if (!detail.empty() && !unbalance) refuse_detail("payload_sag", detail, "nothing or \"unbalance\"");
  const Unit unit = column.ends_with("_kg") ? Unit::urad_per_kg : Unit::urad;
  Formula formula{
      .id = unbalance ? "payload_sag:unbalance" : "payload_sag",
      .moves_table = true,
      .depends_on = {column, std::string(1, context.tilt_letter) + "_deg"},
      .parameters = {{"sin", unit}, {"cos", unit}, {"seat", unit}},
      .keys = {{"column", column}},
  };
  if (unbalance) {
    formula.depends_on.emplace_back("C_deg");
    formula.parameters.push_back({"cos_cosC", unit});
    formula.parameters.push_back({"cos_sinC", unit});
  }
  formula.basis = [=, chain = context.chain](const Situation& s, const Eigen::VectorXd&) {
    const double load = beyond_zero(s, column);
    const RelativeErrorJacobian j = relative_error_jacobian(*chain, s.at, {s.point_r_mm, s.tool_length_mm});
    const Eigen::Vector3d u = chain->rotary_joints()[chain->tilt_index()].direction;
    const Vector6d here = load * j.here.middleCols<3>(3) * u, reference = load * j.reference.middleCols<3>(3) * u;
    const double a = s.at.a.in_radians(), c = s.at.c.in_radians();
    Matrix6Xd b(6, unbalance ? 5 : 3);
    b.col(0) = std::sin(a) * here;
    b.col(1) = std::cos(a) * here + reference;
    b.col(2) = s.reading == ReadingKind::none ? Vector6d::Zero().eval() : (-reference).eval();
    if (unbalance) {
      b.col(3) = std::cos(a) * std::cos(c) * here + reference;
      b.col(4) = std::cos(a) * std::sin(c) * here;
    }
    return b;
  };
  return formula;
}

bool table_tilts(const EffectContext& context) {
  const KinematicChain& chain = *context.chain;
  return chain.rotary_joints()[chain.tilt_index()].side == Side::workpiece && !chain.turn_carries_tilt();
}

}  // namespace

Family payload_sag_family() {
  return {
      .name = "payload_sag",
      .what = "the tilting table gives way under its load",
      .remedy = "tilts 0, -45 and -90 deg with and without load, with the load in a column such as payload_kg",
      .absurd = from_unit(50, Unit::urad_per_kg),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            const std::vector<std::string> columns = columns_named(scope, {"payload", "load", "mass", "weight", "_kg"});
            if (columns.empty() || !table_tilts(scope.context)) return found;
            for (const char* detail : {"", "unbalance"})
              found.push_back(make_effect(payload_sag(detail, columns.front(), scope.context)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        return make_effect(payload_sag(detail, text_key(json, "column", "payload_sag"), context), json);
      },
  };
}

}  // namespace trunnion
