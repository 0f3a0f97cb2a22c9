#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "discovery/candidate.h"
#include "discovery/holdout.h"

namespace trunnion {

/// The search as it stands: the readings and how they are split, the map's basis and prior, the effects accepted so
/// far, and the two bases that new ones are judged against.
class Workbench {
 public:
  Workbench(const ObservationSet& all, std::size_t verification_from, const Machine& machine, int folds);

  const LinearProblem& problem() const { return problem_; }
  const Split& split() const { return split_; }
  const HarmonicBasis& basis() const { return basis_; }
  const SmoothPrior& prior() const { return prior_; }
  const SmoothDesign& design() const { return design_; }
  int map_version() const { return map_version_; }  ///< changes with the columns of the design
  const std::vector<bool>& used() const { return used_; }
  std::vector<bool> searched() const;  ///< in use and not kept back
  Eigen::Index size() const { return y_.size(); }

  std::vector<Candidate> accepted;
  EffectColumns accepted_columns(std::size_t without = static_cast<std::size_t>(-1)) const {
    return side_by_side(accepted, size(), without);
  }

  void set_used(std::vector<bool> used) { used_ = std::move(used); }
  /// Sparse far-off readings go, judged in the model with what was accepted so far; a crowd stays: it is an effect.
  void find_chips();
  /// The prior anew by restricted maximum likelihood of `rows`, and both bases with it.
  void refit(const std::vector<bool>& rows);
  /// Another basis for the map; refit follows.
  void set_basis(const HarmonicBasis& basis);

  const SmoothProjection& smooth() const { return *smooth_; }
  const FreePoseProjection* free() const { return free_.get(); }  ///< none where no free poses can be fitted
  /// The smaller of both bases' chi-square tails, with what a candidate gains in each taken off.
  double chi2_p(const CandidateScore& by_smooth = {}, const CandidateScore& by_free = {}) const;

  ProjectionInput input(std::vector<bool> rows, EffectColumns effects) const {
    return {&problem_, std::move(rows), y_, std::move(effects)};
  }
  /// The error at the poses kept back; without any, at the folds.
  HoldoutError holdout(const EffectColumns& effects) const {
    return split_.has_holdout() ? holdout_error(input(used_, effects), design_, {split_.holdout}) : folds(effects);
  }
  /// The error at the poses that are searched, left out fold by fold.
  HoldoutError folds(const EffectColumns& effects) const {
    return holdout_error(input(searched(), effects), design_, split_.folds);
  }
  /// The smooth fit of `rows` with `effects`, at the prior given or one found.
  SmoothFit fit(const HarmonicBasis& basis, const std::vector<bool>& rows, const EffectColumns& effects,
                const std::optional<SmoothPrior>& prior) const;
  /// Root mean square residual of `rows` with `effects`, um (rotations at 100 mm), at the prior as it stands.
  double rms_um(const std::vector<bool>& rows, const EffectColumns& effects) const;

 private:
  SmoothOptions smooth_options(const std::vector<bool>& rows, const EffectColumns& effects) const;

  LinearProblem problem_;
  Split split_;
  HarmonicBasis basis_;
  SmoothPrior prior_;
  bool has_prior_ = false;
  SmoothDesign design_;
  int map_version_ = 0;
  Eigen::VectorXd y_;
  std::vector<bool> used_;
  std::unique_ptr<SmoothProjection> smooth_;
  std::unique_ptr<FreePoseProjection> free_;
};

/// sqrt of the mean square of `residual` (mm, rad) over `rows`, um; rotations as displacements at 100 mm.
double residual_rms_um(const LinearProblem& problem, const std::vector<double>& residual,
                       const std::vector<bool>& rows);

}  // namespace trunnion
