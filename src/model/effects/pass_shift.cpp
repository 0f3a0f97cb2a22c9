#include <charconv>
#include <set>

#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// All readings of one pass stand off by d = g in R: the probe was taken out and zeroed again.
Formula pass_shift(const std::string& detail) {
  int pass = 0;
  const char* last = detail.data() + detail.size();
  if (std::from_chars(detail.data(), last, pass).ptr != last || pass < 1)
    refuse_detail("pass_shift", detail, "the number of a pass after the first (1, 2, …)");
  Formula formula{
      .id = "pass_shift:" + std::to_string(pass),
      .origin = Origin::measurement,
      .depends_on = {"repeat"},
      .basis =
          [pass](const Situation& s, const Eigen::VectorXd&) {
            return translations(s.reading != ReadingKind::none && s.repeat == pass ? 1 : 0);
          },
  };
  for (const char* name : {"X", "Y", "Z"}) formula.parameters.push_back({name, Unit::um, 0, from_unit(200, Unit::um)});
  return formula;
}

}  // namespace

Family pass_shift_family() {
  return {
      .name = "pass_shift",
      .what = "a pass stands off as a whole, as after zeroing the probe again",
      .remedy = "further passes, with repeat recorded",
      .candidates =
          [](const CandidateScope& scope) {
            constexpr std::size_t kMostPasses = 12;
            std::set<int> passes;
            for (const Situation& s : scope.readings) passes.insert(s.repeat);
            std::vector<EffectPtr> found;
            for (const int pass : passes)
              if (pass >= 1 && found.size() < kMostPasses)
                found.push_back(make_effect(pass_shift(std::to_string(pass))));
            return passes.size() > 1 ? found : std::vector<EffectPtr>();
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(pass_shift(detail), json);
      },
  };
}

}  // namespace trunnion
