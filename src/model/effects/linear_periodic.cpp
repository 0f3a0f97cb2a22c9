#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

constexpr double kShortest_mm = 6;
constexpr double kLongest_mm = 42;
constexpr int kMostPeriods = 60;  // an axis

/// A screw or a scale that errs once a pitch P:  d_x = -(a cos(2 pi x / P) + b sin(2 pi x / P)).
Formula linear_periodic(const std::string& detail, double period_mm) {
  if (detail != "X" && detail != "Y" && detail != "Z") refuse_detail("linear_periodic", detail, "an axis X, Y or Z");
  const Eigen::Index axis = detail[0] - 'X';
  return {
      .id = "linear_periodic:" + detail,
      .depends_on = {std::string(1, static_cast<char>('x' + axis)) + "_mm"},
      .parameters = {{"cos", Unit::um}, {"sin", Unit::um}},
      .shape = {{"period", Unit::mm, period_mm}},
      .shape_ranges = {{.low = 1e-3, .high = 1e4}},
      .basis =
          [axis](const Situation& s, const Eigen::VectorXd& shape) {
            Matrix6Xd b = Matrix6Xd::Zero(6, 2);
            const double phase = 2 * std::numbers::pi * s.point_r_mm[axis] / shape[0];
            b(axis, 0) = -std::cos(phase);
            b(axis, 1) = -std::sin(phase);
            return b;
          },
  };
}

/// Periods with a step of 1 / (1.5 length) in wave number: neighbours share more than half of each other.
std::vector<EffectPtr> scanned(const CandidateScope& scope) {
  std::vector<EffectPtr> found;
  for (const char axis : {'X', 'Y', 'Z'}) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Situation& s : scope.readings) {
      low = std::min(low, s.point_r_mm[axis - 'X']);
      high = std::max(high, s.point_r_mm[axis - 'X']);
    }
    if (!(high - low > kShortest_mm)) continue;
    const double first = 1 / kLongest_mm, last = 1 / kShortest_mm;
    const int steps = std::clamp(static_cast<int>(std::ceil((last - first) * 1.5 * (high - low))), 4, kMostPeriods - 1);
    for (int i = 0; i <= steps; ++i)
      found.push_back(make_effect(linear_periodic({axis}, 1 / (first + (last - first) * i / steps))));
  }
  return found;
}

}  // namespace

Family linear_periodic_family() {
  return {
      .name = "linear_periodic",
      .what = "a ball screw or scale errs once a pitch",
      .remedy = "touches at irregular places along the axis, several within one pitch",
      .absurd = from_unit(20, Unit::um),
      .candidates = scanned,
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(linear_periodic(detail, 10), json);
      },
  };
}

}  // namespace trunnion
