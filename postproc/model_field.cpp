#include "postproc/model_field.h"

#include "model/effects/rotary_error_map.h"

namespace trunnion {

ModelField::ModelField(const Model& model, const std::map<std::string, double>& covariates, Range<Angle> stroke)
    : model_(model), range_(stroke) {
  if (const RotaryErrorMap* map = model.rotary_map()) range_ = map->surface().a_range();
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

PoseError ModelField::at(const Situation& situation) const {
  Situation full = situation;
  full.time_s = time_s_;
  full.temperature_C = temperature_C_;
  full.extra = {&names_, values_.data()};
  return relative_error(model_, full);
}

}  // namespace trunnion
