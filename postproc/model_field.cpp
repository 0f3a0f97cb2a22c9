#include "postproc/model_field.h"

#include <algorithm>

#include "model/effects/rotary_error_map.h"

namespace trunnion {

ModelField::ModelField(const Model& model, const std::map<std::string, double>& covariates, Range<Angle> stroke)
    : model_(model), range_(stroke) {
  if (const RotaryErrorMap* map = model.rotary_map()) range_ = map->surface().a_range();
  for (const EffectPtr& effect : model.effects)
    if (effect->is_compensated())
      for (const std::string& column : effect->depends_on()) knows_senses_ |= column.ends_with("_dir");
  for (const auto& [name, value] : covariates) {
    if (name == "time_s") {
      time_s_ = value;
    } else if (name == "temperature_C") {
      temperature_C_ = value;
    } else {
      names_.push_back(name);
      values_.push_back(value);
    }
  }
}

bool ModelField::bake(const KinematicChain& chain) {
  if (chain.has_rotary(Side::tool)) return false;
  for (const EffectPtr& effect : model_.effects) {
    if (!effect->is_compensated()) continue;
    for (const std::string& column : effect->depends_on())
      if (column != "A_deg" && column != "B_deg" && column != "C_deg" && column != "time_s" &&
          column != "temperature_C" && std::ranges::find(names_, column) == names_.end())
        return false;
  }
  // A twentieth of what four decimals of mm can say.
  const BakeTolerance tolerance{.displacement = Length::micrometres(0.005), .rotation = Angle::microradians(0.02)};
  // A correction's own step may leave the measured range.
  const Angle margin = 0.5 * ErrorSurface::kMargin;
  auto baked = std::make_unique<BakedMap>(
      [this](IndexedPosition position) {
        Situation situation;
        situation.at = position;
        return at(situation);
      },
      Range<Angle>{range_.low - margin, range_.high + margin}, tolerance);
  if (!baked->meets(tolerance)) return false;
  baked_ = std::move(baked);
  return true;
}

ErrorField::Slopes ModelField::with_slopes(const Situation& situation) const {
  if (!baked_) return ErrorField::with_slopes(situation);
  const PoseErrorSlopes slopes = baked_->with_slopes(situation.at);
  return {slopes.error, slopes.by_a, slopes.by_c, true};
}

PoseError ModelField::at(const Situation& situation) const {
  return baked_ ? baked_->at(situation.at) : exactly_at(situation);
}

PoseError ModelField::exactly_at(const Situation& situation) const {
  Situation full = situation;
  full.time_s += time_s_;
  full.temperature_C = temperature_C_;
  full.extra = {&names_, values_.data()};
  return relative_error(model_, full);
}

}  // namespace trunnion
