#include "discovery/holdout.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace trunnion {

bool Split::has_holdout() const {
  return std::ranges::any_of(holdout, [](bool b) { return b; });
}

std::vector<std::vector<bool>> Split::parts() const {
  return has_holdout() ? std::vector<std::vector<bool>>{holdout} : folds;
}

Split split_by_poses(const LinearProblem& problem, std::size_t verification_from, int folds) {
  const std::size_t n = problem.readings.size();
  Split split{.search = std::vector<bool>(n, true), .holdout = std::vector<bool>(n, false)};
  if (verification_from >= problem.observations->rows.size()) {
    for (int f = 0; f < folds; ++f) {
      std::vector<bool> out(n, false);
      for (std::size_t i = 0; i < n; ++i)
        out[i] = !problem.poses[problem.readings[i].pose].reference &&
                 static_cast<int>(problem.readings[i].pose) % folds == f;
      if (std::ranges::any_of(out, [](bool b) { return b; })) split.folds.push_back(std::move(out));
    }
    return split;
  }
  std::size_t visits = 0;
  bool kept_back = false;
  for (std::size_t i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[i];
    if (reading.row < verification_from || problem.poses[reading.pose].reference) continue;
    const bool moved =
        i == 0 || reading.pose != problem.readings[i - 1].pose || problem.readings[i - 1].row < verification_from;
    if (moved) kept_back = visits++ % 2 == 1;
    split.holdout[i] = kept_back;
    split.search[i] = !kept_back;
  }
  return split;
}

HoldoutError holdout_error(const ProjectionInput& input, const SmoothDesign& design,
                           const std::vector<std::vector<bool>>& parts) {
  const LinearProblem& problem = *input.problem;
  HoldoutError error;
  double sum_um = 0, sum = 0, count = 0;
  for (const std::vector<bool>& out : parts) {
    ProjectionInput rest = input;
    std::vector<Eigen::Index> rows;
    for (std::size_t i = 0; i < out.size(); ++i)
      if (out[i] && input.used[i]) rows.push_back(static_cast<Eigen::Index>(i)), rest.used[i] = false;
    if (rows.empty()) continue;
    const SmoothProjection::Prediction p = SmoothProjection(rest, design).predict(rows);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(p.error.size(), p.error.size());
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(p.factor);
    const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
    const Eigen::VectorXd innovation = factor.matrixL().solve(p.error);
    const Eigen::VectorXd deviation = factor.matrixLLT().diagonal();
    std::size_t pose = problem.poses.size();
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const Reading& reading = problem.readings[static_cast<std::size_t>(rows[k])];
      if (reading.pose != pose) error.log_density.push_back(0), pose = reading.pose;
      error.log_density.back() -= 0.5 * innovation[i] * innovation[i] + std::log(deviation[i]);
      sum += innovation[i] * innovation[i];
      sum_um += std::pow(p.error[i] * reading.sigma * (reading.angular ? 1e5 : 1e3), 2);
      ++count;
    }
  }
  if (count > 0) error.rms_um = std::sqrt(sum_um / count), error.innovation = sum / count;
  return error;
}

bool falls(const HoldoutError& before, const HoldoutError& after) {
  const std::size_t n = before.log_density.size();
  if (n < 2 || after.log_density.size() != n) return false;
  double total = 0, square = 0;
  for (std::size_t p = 0; p < n; ++p) total += after.log_density[p] - before.log_density[p];
  const double mean = total / static_cast<double>(n);
  for (std::size_t p = 0; p < n; ++p) square += std::pow(after.log_density[p] - before.log_density[p] - mean, 2);
  const double standard_error = std::sqrt(square * static_cast<double>(n) / static_cast<double>(n - 1));
  return after.rms_um < before.rms_um && after.innovation < before.innovation && total > standard_error;
}

}  // namespace trunnion
