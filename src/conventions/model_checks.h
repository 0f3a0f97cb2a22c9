#pragma once

#include "conventions/check.h"
#include "kinematics/machine.h"
#include "model/model.h"
#include "probing/observation.h"

namespace trunnion {

/// What a model leaves at the reference pose, its largest deviation 100 mm from R's origin against the machine's limits
/// (beyond them a correction is refused), and the covariates that a job has to tell.
Checks model_checks(const Model& model, const Machine& machine);

/// How much of a model is in readings that were taken on the uncorrected machine: the k of
///   value = k (functional . Delta_model) + spots and zeros + noise,
/// weighted least squares; 1 where the model's signs are right, -1 where they are reversed and a correction would
/// double the errors. Two touches of one spot, at the reference pose and where the model is largest, are enough.
struct SignOfErrors {
  double k = 0, std = 0;
  std::size_t readings = 0, beyond = 0;  ///< looked at; left aside beyond the probed range
};
SignOfErrors sign_of_errors(const ObservationSet& observations, const Model& model, const Machine& machine);
/// The same as a check.
Check sign_check(const ObservationSet& observations, const Model& model, const Machine& machine);

}  // namespace trunnion
