#include "identification/free_pose_fit.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

constexpr double kLever_mm = 100;        // angles are scaled by it, so that all six freedoms are lengths
constexpr double kRankTolerance = 1e-9;  // of the largest singular value

const Vector6d kScale = (Vector6d() << 1, 1, 1, 1 / kLever_mm, 1 / kLever_mm, 1 / kLever_mm).finished();

/// The inverse of a symmetric block on what its readings see, and the directions they do not.
struct BlockInverse {
  Matrix6d inverse = Matrix6d::Zero();
  std::vector<Vector6d> null;
  double condition = 1;
  int rank = 0;
};

BlockInverse invert(const Matrix6d& normal) {
  BlockInverse result;
  const SymmetricEigen eigen(normal);
  const double largest = eigen.eigenvalues()[5];
  double smallest = largest;
  for (int k = 0; k < 6; ++k) {
    const double value = eigen.eigenvalues()[k];
    const Vector6d v = eigen.eigenvectors().col(k);
    if (!(value > kRankTolerance * largest)) {
      result.null.push_back(v);
      continue;
    }
    result.inverse += v * v.transpose() / value;
    smallest = std::min(smallest, value);
    ++result.rank;
  }
  result.condition = smallest > 0 ? std::sqrt(largest / smallest) : 1;
  return result;
}

UnseenFreedom name_freedom(std::uint32_t pose, const Vector6d& direction) {
  UnseenFreedom freedom{.pose = pose, .direction = direction};
  for (Eigen::Index k = 0; k < 6; ++k)
    if (std::abs(direction[k]) > 1e-3) freedom.components.push_back(static_cast<std::size_t>(k));
  return freedom;
}

/// The normal equations, one block a pose, bordered by the unknowns.
struct Blocks {
  std::vector<Matrix6d> normal;
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> border;
  Eigen::MatrixXd corner;
  std::vector<BlockInverse> inverse;
  Eigen::MatrixXd schur_inverse;
  Eigen::Index schur_rank = 0;
  std::vector<Eigen::Index> undetermined;
};

Blocks assemble(const LinearProblem& problem, const std::vector<bool>& used) {
  const auto unknowns = static_cast<Eigen::Index>(problem.unknowns.size());
  Blocks b;
  b.normal.assign(problem.poses.size(), Matrix6d::Zero());
  b.border.assign(problem.poses.size(), Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, unknowns));
  b.corner = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (std::size_t i = 0; i < problem.readings.size(); ++i) {
    if (!used.empty() && !used[i]) continue;
    const Reading& reading = problem.readings[i];
    const double weight = 1 / (reading.sigma * reading.sigma);
    const Vector6d g = reading.functional.cwiseProduct(kScale);
    const bool free = !problem.poses[reading.pose].reference;
    if (free) b.normal[reading.pose] += weight * g * g.transpose();
    for (const auto& [k, u] : problem.terms_of(reading)) {
      if (free) b.border[reading.pose].col(k) += weight * u * g;
      for (const auto& [l, v] : problem.terms_of(reading)) b.corner(k, l) += weight * u * v;
    }
  }
  Eigen::MatrixXd schur = b.corner;
  b.inverse.resize(problem.poses.size());
  for (std::size_t p = 0; p < problem.poses.size(); ++p) {
    if (problem.poses[p].reference) continue;
    b.inverse[p] = invert(b.normal[p]);
    schur -= b.border[p].transpose() * b.inverse[p].inverse * b.border[p];
  }
  const SymmetricEigen eigen(schur);
  const double largest = unknowns > 0 ? std::max(eigen.eigenvalues()[unknowns - 1], b.corner.diagonal().maxCoeff()) : 0;
  b.schur_inverse = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    const Eigen::VectorXd v = eigen.eigenvectors().col(k);
    if (eigen.eigenvalues()[k] > kRankTolerance * largest) {
      b.schur_inverse += v * v.transpose() / eigen.eigenvalues()[k];
      ++b.schur_rank;
    } else {
      Eigen::Index worst = 0;
      v.cwiseAbs().maxCoeff(&worst);
      b.undetermined.push_back(worst);
    }
  }
  return b;
}

struct Solution {
  std::vector<Vector6d> delta;  // scaled
  Eigen::VectorXd unknowns;
};

Solution solve(const LinearProblem& problem, const Blocks& b, const std::vector<bool>& used,
               const std::vector<double>& value) {
  std::vector<Vector6d> rhs(problem.poses.size(), Vector6d::Zero());
  Eigen::VectorXd corner = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.unknowns.size()));
  for (std::size_t i = 0; i < problem.readings.size(); ++i) {
    if (!used.empty() && !used[i]) continue;
    const Reading& reading = problem.readings[i];
    const double weighted = value[i] / (reading.sigma * reading.sigma);
    if (!problem.poses[reading.pose].reference) rhs[reading.pose] += weighted * reading.functional.cwiseProduct(kScale);
    for (const auto& [k, u] : problem.terms_of(reading)) corner[k] += weighted * u;
  }
  for (std::size_t p = 0; p < problem.poses.size(); ++p)
    if (!problem.poses[p].reference) corner -= b.border[p].transpose() * (b.inverse[p].inverse * rhs[p]);
  Solution s{std::vector<Vector6d>(problem.poses.size(), Vector6d::Zero()), b.schur_inverse * corner};
  for (std::size_t p = 0; p < problem.poses.size(); ++p)
    if (!problem.poses[p].reference) s.delta[p] = b.inverse[p].inverse * (rhs[p] - b.border[p] * s.unknowns);
  return s;
}

double fitted(const LinearProblem& problem, const Reading& reading, const Solution& s) {
  double value = reading.functional.cwiseProduct(kScale).dot(s.delta[reading.pose]);
  for (const auto& [k, u] : problem.terms_of(reading)) value += u * s.unknowns[k];
  return value;
}

/// Values less what the exact readings exceed the linear ones by.
std::vector<double> linearised_values(const LinearProblem& problem, const Solution& s, double& largest_excess) {
  std::vector<double> value(problem.readings.size());
  largest_excess = 0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const Reading& reading = problem.readings[i];
    const PoseError delta = PoseError::from_vector(s.delta[reading.pose].cwiseProduct(kScale));
    const auto terms = problem.terms_of(reading);
    const double offset = terms.empty() ? 0 : s.unknowns[terms[0].first];
    const double excess = nonlinear_excess_mm(problem, reading, delta, offset);
    largest_excess = std::max(largest_excess, std::abs(excess) / reading.sigma);
    value[i] = reading.value - excess;
  }
  return value;
}

void number_columns(const LinearProblem& problem, FreePoseFit& fit) {
  fit.column.assign(problem.poses.size(), -1);
  std::ptrdiff_t next = 0;
  for (std::size_t p = 0; p < problem.poses.size(); ++p)
    if (!problem.poses[p].reference) fit.column[p] = 6 * next++;
  fit.covariance = Eigen::MatrixXd::Zero(6 * next, 6 * next);
}

}  // namespace

FreePoseFit fit_free_poses(const LinearProblem& problem, const std::vector<bool>& used) {
  if (problem.has_pose_kind)
    throw ModelError(
        "poses seen by an instrument leave free pose errors undetermined; only a smooth map can be fitted to them");
  if (!problem.poses.empty() && problem.poses.back().moving)
    throw ModelError("the points of a piece share no pose error; only a smooth map can be fitted to them");
  const Blocks b = assemble(problem, used);
  std::vector<double> value(problem.readings.size());
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = problem.readings[i].value;
  Solution s = solve(problem, b, used, value);
  constexpr double kNegligible = 1e-6;  // of sigma
  for (int iteration = 0; iteration < 6; ++iteration) {
    double largest_excess = 0;
    std::vector<double> next = linearised_values(problem, s, largest_excess);
    double change = 0;
    for (std::size_t i = 0; i < value.size(); ++i)
      change = std::max(change, std::abs(next[i] - value[i]) / problem.readings[i].sigma);
    if (change < kNegligible) break;
    value = std::move(next);
    s = solve(problem, b, used, value);
  }

  FreePoseFit fit;
  number_columns(problem, fit);
  fit.unknowns = s.unknowns;
  for (std::size_t p = 0; p < problem.poses.size(); ++p) {
    fit.delta.push_back(PoseError::from_vector(s.delta[p].cwiseProduct(kScale)));
    if (problem.poses[p].reference) continue;
    fit.unknown_count += 6;
    fit.rank += static_cast<std::size_t>(b.inverse[p].rank);
    fit.condition = std::max(fit.condition, b.inverse[p].condition);
    for (const Vector6d& v : b.inverse[p].null) fit.unseen.push_back(name_freedom(static_cast<std::uint32_t>(p), v));
  }
  fit.unknown_count += problem.unknowns.size();
  fit.rank += static_cast<std::size_t>(b.schur_rank);
  for (const Eigen::Index k : b.undetermined)
    fit.undetermined_unknowns.push_back(problem.unknowns[static_cast<std::size_t>(k)]);

  // Covariance: C_pq = delta_pq N_p^-1 + (N_p^-1 B_p) S^-1 (N_q^-1 B_q)^T, and the unknowns' with it.
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> gain(problem.poses.size());
  for (std::size_t p = 0; p < problem.poses.size(); ++p)
    gain[p] = kScale.asDiagonal() * (b.inverse[p].inverse * b.border[p]);
  Eigen::MatrixXd stacked(fit.covariance.rows(), b.corner.cols());
  for (std::size_t p = 0; p < problem.poses.size(); ++p)
    if (fit.column[p] >= 0) stacked.middleRows<6>(fit.column[p]) = gain[p];
  const Eigen::MatrixXd border_covariance = stacked * b.schur_inverse;
  fit.covariance.noalias() = border_covariance * stacked.transpose();
  for (std::size_t p = 0; p < problem.poses.size(); ++p)
    if (fit.column[p] >= 0)
      fit.covariance.block<6, 6>(fit.column[p], fit.column[p]) +=
          kScale.asDiagonal() * b.inverse[p].inverse * kScale.asDiagonal();

  for (std::size_t i = 0; i < problem.readings.size(); ++i) {
    const Reading& reading = problem.readings[i];
    const bool in = used.empty() || used[i];
    const double residual = value[i] - fitted(problem, reading, s);
    fit.residual.push_back(residual);
    if (in) {
      fit.weighted_rss += std::pow(residual / reading.sigma, 2);
      ++fit.readings;
    }
    // h = x^T C x / sigma^2, with x over this pose and this reading's unknowns only.
    double variance = 0;
    const std::ptrdiff_t column = fit.column[reading.pose];
    const auto terms = problem.terms_of(reading);
    if (column >= 0) {
      variance += reading.functional.dot(fit.covariance.block<6, 6>(column, column) * reading.functional);
      for (const auto& [k, u] : terms)
        variance -= 2 * u * reading.functional.dot(border_covariance.block<6, 1>(column, k));
    }
    for (const auto& [k, u] : terms)
      for (const auto& [l, v] : terms) variance += u * v * b.schur_inverse(k, l);
    fit.redundancy.push_back(in ? std::clamp(1 - variance / (reading.sigma * reading.sigma), 0.0, 1.0) : 0.0);
  }
  return fit;
}

FreePoseFit fit_two_step(const LinearProblem& problem) {
  const std::size_t unknowns = problem.unknowns.size();
  std::vector<double> reference_sum(unknowns, 0), reference_count(unknowns, 0), reference_sigma(unknowns, 0);
  for (const Reading& reading : problem.readings) {
    if (problem.observations->rows[reading.row].kind != ReadingKind::contact)
      throw InputError(problem.observations->place(reading.row), "the two-step method knows contact readings only");
    if (!problem.poses[reading.pose].reference) continue;
    const auto k = problem.terms_of(reading)[0].first;
    reference_sum[k] += reading.value / problem.terms_of(reading)[0].second;
    reference_sigma[k] = reading.sigma;
    ++reference_count[k];
  }
  FreePoseFit fit;
  number_columns(problem, fit);
  fit.unknowns = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns));
  for (std::size_t k = 0; k < unknowns; ++k)
    if (reference_count[k] > 0) fit.unknowns[static_cast<Eigen::Index>(k)] = reference_sum[k] / reference_count[k];

  std::vector<Matrix6d> normal(problem.poses.size(), Matrix6d::Zero());
  std::vector<Vector6d> rhs(problem.poses.size(), Vector6d::Zero());
  for (const Reading& reading : problem.readings) {
    const auto& [k, u] = problem.terms_of(reading)[0];
    if (reference_count[k] == 0)
      throw InputError(problem.observations->place(reading.row),
                       problem.unknowns[k] + " was not probed at the reference pose; the two-step method needs that");
    const Vector6d g = reading.functional.cwiseProduct(kScale);
    const double difference = reading.value - u * fit.unknowns[static_cast<Eigen::Index>(k)];
    normal[reading.pose] += g * g.transpose();
    rhs[reading.pose] += difference * g;
  }
  // Each pose's estimate is linear in its own readings and in the reference means: keep both operators for the
  // covariance.
  Eigen::MatrixXd of_reference = Eigen::MatrixXd::Zero(fit.covariance.rows(), static_cast<Eigen::Index>(unknowns));
  std::vector<BlockInverse> inverse(problem.poses.size());
  for (std::size_t p = 0; p < problem.poses.size(); ++p) {
    fit.delta.emplace_back();
    if (problem.poses[p].reference) continue;
    inverse[p] = invert(normal[p]);
    fit.delta[p] = PoseError::from_vector(kScale.asDiagonal() * (inverse[p].inverse * rhs[p]));
    fit.rank += static_cast<std::size_t>(inverse[p].rank);
    fit.unknown_count += 6;
    fit.condition = std::max(fit.condition, inverse[p].condition);
    for (const Vector6d& v : inverse[p].null) fit.unseen.push_back(name_freedom(static_cast<std::uint32_t>(p), v));
  }
  for (const Reading& reading : problem.readings) {
    const std::ptrdiff_t column = fit.column[reading.pose];
    const auto& [k, u] = problem.terms_of(reading)[0];
    if (column >= 0) {
      const Vector6d operator_column =
          kScale.asDiagonal() * (inverse[reading.pose].inverse * reading.functional.cwiseProduct(kScale));
      fit.covariance.block<6, 6>(column, column) +=
          std::pow(reading.sigma, 2) * operator_column * operator_column.transpose();
      of_reference.block<6, 1>(column, k) -= u * operator_column;
    }
    const double residual = reading.value - u * fit.unknowns[static_cast<Eigen::Index>(k)] -
                            reading.functional.dot(fit.delta[reading.pose].vector());
    fit.residual.push_back(residual);
    fit.weighted_rss += std::pow(residual / reading.sigma, 2);
    ++fit.readings;
    // Redundancy within the pose's own fit of differences.
    const Vector6d g = reading.functional.cwiseProduct(kScale);
    fit.redundancy.push_back(column >= 0 ? std::clamp(1 - g.dot(inverse[reading.pose].inverse * g), 0.0, 1.0) : 0.0);
  }
  for (std::size_t k = 0; k < unknowns; ++k) {
    if (reference_count[k] == 0) continue;
    const Eigen::VectorXd column = of_reference.col(static_cast<Eigen::Index>(k));
    fit.covariance += std::pow(reference_sigma[k], 2) / reference_count[k] * column * column.transpose();
  }
  fit.unknown_count += unknowns;
  fit.rank += static_cast<std::size_t>(
      std::count_if(reference_count.begin(), reference_count.end(), [](double n) { return n > 0; }));
  return fit;
}

}  // namespace trunnion
