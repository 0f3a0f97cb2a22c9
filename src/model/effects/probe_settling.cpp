#include <algorithm>
#include <cmath>

#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// Something settles while touches are taken:
///   probe_settling        y = n . g k             k the touch's number in its pose (a brake that creeps),
///   probe_settling:first  y = n . g exp(-i / m)   i the touch's number over all (a cold probe, a seat), m touches.
Formula probe_settling(const std::string& detail, double decay) {
  if (!detail.empty() && detail != "first") refuse_detail("probe_settling", detail, "nothing or \"first\"");
  Formula formula{.id = detail.empty() ? "probe_settling" : "probe_settling:first", .origin = Origin::measurement};
  for (const char* name : {"X", "Y", "Z"})
    formula.parameters.push_back({name, Unit::um, 0, from_unit(detail.empty() ? 5 : 50, Unit::um)});
  if (detail.empty()) {
    formula.depends_on = {"order_in_pose"};
    formula.basis = [](const Situation& s, const Eigen::VectorXd&) {
      return translations(s.reading == ReadingKind::none ? 0 : s.order_in_pose);
    };
  } else {
    formula.depends_on = {"order"};
    formula.shape = {{"decay_touches", Unit::one, decay}};
    formula.shape_ranges = {{.low = 0.1, .high = 1e6}};
    formula.basis = [](const Situation& s, const Eigen::VectorXd& shape) {
      return translations(s.reading == ReadingKind::none ? 0 : std::exp(-s.order / shape[0]));
    };
  }
  return formula;
}

}  // namespace

Family probe_settling_family() {
  return {
      .name = "probe_settling",
      .what = "readings settle: within a pose, or over the first touches of all",
      .remedy = "spots in random order within the poses; twenty touches before the first that counts",
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            const auto later = [](const Situation& s) { return s.order_in_pose > 0; };
            if (std::ranges::any_of(scope.readings, later)) found.push_back(make_effect(probe_settling("", 0)));
            for (const double decay : {3.0, 10.0, 30.0})
              if (static_cast<double>(scope.readings.size()) > 3 * decay)
                found.push_back(make_effect(probe_settling("first", decay)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(probe_settling(detail, 10), json);
      },
  };
}

}  // namespace trunnion
