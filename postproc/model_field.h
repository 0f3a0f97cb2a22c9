#pragma once

#include <map>
#include <memory>

#include "errormap/baked_map.h"
#include "model/model.h"
#include "postproc/correction.h"

namespace trunnion {

/// The machine's effects of a model as an ErrorField, covariates held at given values (those not given stand at their
/// zero); time counts from the one given.
class ModelField : public ErrorField {
 public:
  /// `model` must outlive it. `stroke`: the tilts to admit where the model holds no rotary error map.
  ModelField(const Model& model, const std::map<std::string, double>& covariates, Range<Angle> stroke);

  PoseError at(const Situation& situation) const override;
  PoseError exactly_at(const Situation& situation) const override;
  Slopes with_slopes(const Situation& situation) const override;
  bool knows_senses() const override { return knows_senses_; }
  Range<Angle> tilt_range() const override { return range_; }

  /// Bakes the model, for programs of many blocks, if its error depends on nothing but A and C (no rotary
  /// axis on the tool side, where the tool's lever counts) and the bake meets its
  /// tolerance (0.005 um at 200 mm); says whether it did.
  bool bake(const KinematicChain& chain);

 private:
  const Model& model_;
  Range<Angle> range_;
  bool knows_senses_ = false;
  double time_s_ = 0;
  double temperature_C_ = 20;
  std::vector<std::string> names_;
  std::vector<double> values_;
  std::unique_ptr<BakedMap> baked_;
};

}  // namespace trunnion
