#include "discovery/holdout.h"

#include <algorithm>
#include <cmath>

#include "linear_algebra/factors.h"

namespace trunnion {

bool Split::has_holdout() const {
  return std::ranges::any_of(holdout, [](bool b) { return b; });
}

namespace {

/// What is looked at, or kept back, together: the pose of each reading, or its block of a log.
std::vector<std::size_t> places(const LinearProblem& problem) {
  constexpr std::size_t kFreedoms = 6, kRuns = 8;
  constexpr double kTilt_deg = 15, kTurn_deg = 30;
  const std::size_t n = problem.readings.size();
  std::vector<std::size_t> place(n);
  const bool log = problem.poses.size() * kFreedoms > n;
  for (std::size_t i = 0; i < n; ++i) {
    place[i] = problem.readings[i].pose;
    if (!log) continue;
    const IndexedPosition at = problem.poses[problem.readings[i].pose].at;
    const auto tilt = static_cast<std::size_t>((at.a.in_degrees() + 720) / kTilt_deg);
    const auto turn = static_cast<std::size_t>(std::fmod(at.c.in_degrees() + 720000, 360) / kTurn_deg);
    place[i] = (i * kRuns / n * 97 + tilt) * 12 + turn;
  }
  return place;
}

}  // namespace

Split split_by_poses(const LinearProblem& problem, std::size_t verification_from, int folds) {
  const std::size_t n = problem.readings.size();
  Split split{.search = std::vector<bool>(n, true), .holdout = std::vector<bool>(n, false)};
  const std::vector<std::size_t> place = places(problem);
  std::size_t visits = 0;
  bool kept_back = false;
  for (std::size_t i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[i];
    if (reading.row < verification_from || problem.poses[reading.pose].reference) continue;
    const bool moved = i == 0 || place[i] != place[i - 1] || problem.readings[i - 1].row < verification_from;
    if (moved) kept_back = visits++ % 2 == 1;
    split.holdout[i] = kept_back;
    split.search[i] = !kept_back;
  }
  for (int f = 0; f < folds; ++f) {
    std::vector<bool> out(n, false);
    for (std::size_t i = 0; i < n; ++i)
      out[i] = split.search[i] && !problem.poses[problem.readings[i].pose].reference &&
               static_cast<int>(place[i]) % folds == f;
    if (std::ranges::any_of(out, [](bool b) { return b; })) split.folds.push_back(std::move(out));
  }
  return split;
}

HoldoutError holdout_error(const ProjectionInput& input, const SmoothDesign& design,
                           const std::vector<std::vector<bool>>& parts) {
  const LinearProblem& problem = *input.problem;
  HoldoutError error;
  double plain = 0, sum = 0, count = 0;
  for (const std::vector<bool>& out : parts) {
    ProjectionInput rest = input;
    std::vector<Eigen::Index> rows;
    for (std::size_t i = 0; i < out.size(); ++i)
      if (out[i] && input.used[i]) rows.push_back(static_cast<Eigen::Index>(i)), rest.used[i] = false;
    if (rows.empty()) continue;
    SmoothProjection::Prediction p = SmoothProjection(rest, design).predict(rows);
    HoldoutError::Part part{std::move(p.error), Eigen::MatrixXd::Identity(p.factor.rows(), p.factor.rows())};
    part.covariance += p.factor * p.factor.transpose();
    const Eigen::VectorXd innovation = Cholesky(part.covariance).half_solve(part.error);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const Reading& reading = problem.readings[static_cast<std::size_t>(rows[k])];
      const double sigma_um = reading.sigma * (reading.angular ? 1e5 : 1e3);
      sum += std::pow(innovation[i] * sigma_um, 2);
      plain += std::pow(part.error[i] * sigma_um, 2);
      ++count;
    }
    error.parts.push_back(std::move(part));
  }
  if (count > 0) error.rms_um = std::sqrt(sum / count), error.plain_rms_um = std::sqrt(plain / count);
  return error;
}

Fall fall(const HoldoutError& before, const HoldoutError& after) {
  // log p1(e - d) - log p0(e), e normal with covariance S0: a quadratic form in z = L0^-1 e.
  Fall fall{.rms_um = before.rms_um - after.rms_um};
  double variance = 0, shift = 0;
  for (std::size_t k = 0; k < before.parts.size(); ++k) {
    const HoldoutError::Part &p0 = before.parts[k], &p1 = after.parts[k];
    const Cholesky root0(p0.covariance), root1(p1.covariance);
    const auto log_density = [](const Cholesky& root, const Eigen::VectorXd& e) {
      return -0.5 * root.half_solve(e).squaredNorm() - root.half_log_determinant();
    };
    fall.gain += log_density(root1, p1.error) - log_density(root0, p0.error);
    const Eigen::MatrixXd mixed = root1.half_solve(root0.lower());  // L1^-1 L0
    const Eigen::VectorXd by = root1.half_solve(p0.error - p1.error);
    Eigen::MatrixXd curved = -mixed.transpose() * mixed;
    curved.diagonal().array() += 1;
    variance += 0.5 * curved.squaredNorm() + (mixed.transpose() * by).squaredNorm();
    shift += by.squaredNorm();
  }
  fall.standard_error = std::sqrt(variance);
  fall.shift = std::sqrt(shift);
  return fall;
}

}  // namespace trunnion
