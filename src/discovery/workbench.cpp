#include "discovery/workbench.h"

#include <algorithm>
#include <cmath>

#include "identification/distributions.h"
#include "identification/outliers.h"

namespace trunnion {
namespace {

constexpr int kFirstHarmonics = 4;  // to begin with; richer maps are offered later

}  // namespace

double residual_rms_um(const LinearProblem& problem, const std::vector<double>& residual,
                       const std::vector<bool>& rows) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < residual.size(); ++i) {
    if (!rows[i]) continue;
    sum += std::pow(residual[i] * (problem.readings[i].angular ? 1e5 : 1e3), 2);
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

Workbench::Workbench(const ObservationSet& all, std::size_t verification_from, const Machine& machine, int folds)
    : problem_(make_linear_problem(all, machine)),
      split_(split_by_poses(problem_, verification_from, folds)),
      basis_(basis_for(problem_, kFirstHarmonics)),
      y_(static_cast<Eigen::Index>(problem_.readings.size())),
      used_(problem_.readings.size(), true) {
  for (Eigen::Index i = 0; i < y_.size(); ++i) {
    const Reading& reading = problem_.readings[static_cast<std::size_t>(i)];
    y_[i] = reading.value / reading.sigma;
  }
  design_ = smooth_design(problem_, basis_, prior_);
}

std::vector<bool> Workbench::searched() const {
  std::vector<bool> rows = split_.search;
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = rows[i] && used_[i];
  return rows;
}

SmoothOptions Workbench::smooth_options(const std::vector<bool>& rows, const EffectColumns& effects) const {
  SmoothOptions o;
  for (const bool r : rows) o.weights.push_back(r ? 1.0 : 0.0);
  o.extra_columns = effects.columns;
  o.extra_precision = effects.precision;
  for (Eigen::Index i = 0; i < o.extra_columns.rows(); ++i)  // unwhitened: fit_smooth divides by sigma itself
    o.extra_columns.row(i) *= problem_.readings[static_cast<std::size_t>(i)].sigma;
  if (has_prior_) o.start = prior_;
  return o;
}

void Workbench::find_chips() {
  const SmoothOptions o = smooth_options(std::vector<bool>(used_.size(), true), accepted_columns());
  OutlierSearch search = find_outliers(problem_, basis_, o);
  used_ = std::move(search.used);
  prior_ = search.fit.prior;
  has_prior_ = true;
}

void Workbench::refit(const std::vector<bool>& rows) {
  prior_ = fit(basis_, rows, accepted_columns(), {}).prior;
  has_prior_ = true;
  design_.precision = smooth_precision(problem_, basis_, prior_);
  const ProjectionInput in = input(rows, accepted_columns());
  free_ = problem_.has_pose_kind ? nullptr : std::make_unique<FreePoseProjection>(in);
  if (free_ && free_->freedom() < 1) free_.reset();
  smooth_ = std::make_unique<SmoothProjection>(in, design_);
}

void Workbench::set_basis(const HarmonicBasis& basis) {
  basis_ = basis;
  design_ = smooth_design(problem_, basis_, prior_);
  ++map_version_;
}

double Workbench::chi2_p(const CandidateScore& by_smooth, const CandidateScore& by_free) const {
  const auto tail = [](const Projection& base, const CandidateScore& s) {
    return chi_square_tail(base.residual_square() - s.gain, base.freedom() - s.rank);
  };
  const double p = tail(*smooth_, by_smooth);
  return free_ ? std::min(p, tail(*free_, by_free)) : p;
}

SmoothFit Workbench::fit(const HarmonicBasis& basis, const std::vector<bool>& rows, const EffectColumns& effects,
                         const std::optional<SmoothPrior>& prior) const {
  SmoothOptions o = smooth_options(rows, effects);
  o.prior = prior;
  return fit_smooth(problem_, basis, o);
}

double Workbench::rms_um(const std::vector<bool>& rows, const EffectColumns& effects) const {
  const Eigen::VectorXd misfit = SmoothProjection(input(rows, effects), design_).misfit();
  std::vector<double> residual(used_.size());
  for (std::size_t i = 0; i < residual.size(); ++i)
    residual[i] = misfit[static_cast<Eigen::Index>(i)] * problem_.readings[i].sigma;
  return residual_rms_um(problem_, residual, rows);
}

}  // namespace trunnion
