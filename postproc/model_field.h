#pragma once

#include <map>

#include "model/model.h"
#include "postproc/correction.h"

namespace trunnion {

/// The machine's effects of a model as an ErrorField, covariates held at given values (those not given stand at their
/// zero).
class ModelField : public ErrorField {
 public:
  /// `model` must outlive it. `stroke`: the tilts to admit where the model holds no rotary error map.
  ModelField(const Model& model, const std::map<std::string, double>& covariates, Range<Angle> stroke);

  PoseError at(const Situation& situation) const override;
  Range<Angle> tilt_range() const override { return range_; }

 private:
  const Model& model_;
  Range<Angle> range_;
  double time_s_ = 0;
  double temperature_C_ = 20;
  std::vector<std::string> names_;
  std::vector<double> values_;
};

}  // namespace trunnion
