#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// The table moves against the tool as the machine warms up, d = D + theta x p at R's origin, zero at time 0:
///   thermal_drift             D = g (1 - exp(-t / tau))      thermal_drift:rotation         theta alike
///   thermal_drift:linear      D = g t                        thermal_drift:linear_rotation  theta alike
///   thermal_drift:cycle       D = g (cos(2 pi t / T) - 1) + h sin(2 pi t / T), an air conditioning that comes and
///   goes.
const char* const kDetails[] = {"", "linear", "rotation", "linear_rotation", "cycle"};
constexpr double kMoved = from_unit(200, Unit::um), kTurned = from_unit(1000, Unit::urad);

Formula base_formula(const std::string& detail) {
  return {.id = detail.empty() ? "thermal_drift" : "thermal_drift:" + detail,
          .moves_table = true,
          .depends_on = {"time_s"}};
}

Formula drift(const std::string& detail, double shape_s) {
  const bool linear = detail.starts_with("linear"), turns = detail.ends_with("rotation");
  Formula formula = base_formula(detail);
  for (const char axis : {'X', 'Y', 'Z'}) {
    const Unit unit = linear ? (turns ? Unit::urad_per_h : Unit::um_per_h) : (turns ? Unit::urad : Unit::um);
    const double bound = (turns ? kTurned : kMoved) / (linear ? 3600 : 1);
    formula.parameters.push_back({std::string(1, turns ? static_cast<char>(axis - 'X' + 'A') : axis), unit, 0, bound});
  }
  if (linear) {
    formula.basis = [turns](const Situation& s, const Eigen::VectorXd&) {
      return turns ? rotations(s.time_s) : translations(s.time_s);
    };
    return formula;
  }
  formula.shape = {{"time_constant", Unit::s, shape_s}};
  formula.shape_ranges = {{.low = 1e-3, .high = 1e9}};
  formula.basis = [turns](const Situation& s, const Eigen::VectorXd& shape) {
    // Before time 0 the exponential would run away; what was then is not known, and held.
    const double rise = -std::expm1(-std::max(0.0, s.time_s) / shape[0]);
    return turns ? rotations(rise) : translations(rise);
  };
  return formula;
}

Formula cycle(double period_s) {
  Formula formula = base_formula("cycle");
  for (const char* name : {"cosX", "cosY", "cosZ", "sinX", "sinY", "sinZ"})
    formula.parameters.push_back({name, Unit::um, 0, kMoved});
  formula.shape = {{"period", Unit::s, period_s}};
  formula.shape_ranges = {{.low = 1e-3, .high = 1e9}};
  formula.basis = [](const Situation& s, const Eigen::VectorXd& shape) {
    const double phase = 2 * std::numbers::pi * s.time_s / shape[0];
    Matrix6Xd b(6, 6);
    b << translations(std::cos(phase) - 1), translations(std::sin(phase));
    return b;
  };
  return formula;
}

Formula thermal_drift(const std::string& detail, double shape_s) {
  if (std::ranges::find(kDetails, detail) == std::end(kDetails))
    refuse_detail("thermal_drift", detail, "nothing, linear, rotation, linear_rotation or cycle");
  return detail == "cycle" ? cycle(shape_s) : drift(detail, shape_s);
}

std::vector<EffectPtr> candidates(const CandidateScope& scope) {
  std::vector<EffectPtr> found;
  const std::optional<ColumnRange> time = spread(scope, "time_s");
  if (!time) return found;
  for (const char* detail : {"", "rotation"})
    for (const double share : {0.03, 0.08, 0.2, 0.5, 1.2})
      found.push_back(make_effect(thermal_drift(detail, share * time->width())));
  for (const char* detail : {"linear", "linear_rotation"}) found.push_back(make_effect(thermal_drift(detail, 0)));
  // Cycles of the room: 3 to 60 minutes, at least twice in the data, a step of one cycle over the whole time.
  constexpr double kShortest_s = 180, kLongest_s = 3600;
  constexpr int kMostCycles = 30;
  const int fewest = std::max(2, static_cast<int>(std::ceil(time->width() / kLongest_s)));
  const int most = std::min(static_cast<int>(time->width() / kShortest_s), fewest + kMostCycles - 1);
  for (int n = fewest; n <= most; ++n) found.push_back(make_effect(cycle(time->width() / n)));
  return found;
}

}  // namespace

Family thermal_drift_family() {
  return {
      .name = "thermal_drift",
      .what = "the table drifts against the tool as time goes on",
      .remedy = "the reference pose once more at the end, and poses in another order, with time_s recorded",
      .candidates = candidates,
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(thermal_drift(detail, 600), json);
      },
  };
}

}  // namespace trunnion
