#include "discovery/candidate.h"

#include <algorithm>
#include <cmath>

#include "identification/distributions.h"
#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

constexpr double kVisible = 1e-3;  // of a column's norm: less than that outside the base is rounding

/// Climbs to the summit of the gain over the numbers of a shape, one after the other.
class ShapeClimb {
 public:
  ShapeClimb(const LinearProblem& problem, const Projection& base, const Candidate& start)
      : problem_(problem), base_(base), best_(start), best_gain_(score(base, start.columns).gain) {
    for (const Parameter& p : start.effect->shape()) x_.push_back(p.value);
  }

  Candidate run() {
    const std::vector<ShapeRange> ranges = best_.effect->shape_ranges();
    for (std::size_t k = 0; k < x_.size(); ++k) climb(k, ranges[k]);
    return std::move(best_);
  }

 private:
  void climb(std::size_t k, const ShapeRange& range) {
    // The profile of a shape is smooth but has more than one summit; the scan that came before found the right one.
    if (range.whole) {
      for (double stride = 16; stride >= 1; stride = std::floor(stride / 2))
        for (int hop = 0; hop < 4 && (try_at(k, x_[k] - stride, range) || try_at(k, x_[k] + stride, range)); ++hop) {
        }
      return;
    }
    const bool positive = range.low > 0;  // a period or time constant: steps are factors
    double step = positive ? 0.35 : 0.1 * (range.high - range.low);
    for (int round = 0; round < 7; ++round, step *= 0.5)
      for (const double sign : {-1.0, 1.0})
        try_at(k, positive ? x_[k] * std::exp(sign * step) : x_[k] + sign * step, range);
  }

  bool try_at(std::size_t k, double value, const ShapeRange& range) {
    std::vector<double> there = x_;
    there[k] = std::clamp(value, range.low, range.high);
    const Eigen::Map<const Eigen::VectorXd> shape(there.data(), static_cast<Eigen::Index>(there.size()));
    Candidate tried = make_candidate(problem_, best_.effect->with_shape(shape));
    const double gain = score(base_, tried.columns).gain;
    if (gain <= best_gain_) return false;
    tried.members = best_.members;
    best_gain_ = gain, best_ = std::move(tried), x_ = std::move(there);
    return true;
  }

  const LinearProblem& problem_;
  const Projection& base_;
  Candidate best_;
  double best_gain_;
  std::vector<double> x_;
};

}  // namespace

Candidate make_candidate(const LinearProblem& problem, EffectPtr effect) {
  const auto n = static_cast<Eigen::Index>(problem.readings.size());
  const auto m = static_cast<Eigen::Index>(effect->parameters().size());
  Candidate candidate{.columns = Eigen::MatrixXd(n, m), .scale = Eigen::VectorXd(m)};
  for (Eigen::Index k = 0; k < m; ++k)
    candidate.scale[k] = from_unit(1, effect->parameters()[static_cast<std::size_t>(k)].unit);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    const Vector6d functional = reading.functional / reading.sigma;
    candidate.columns.row(i) = functional.transpose() * effect->basis(problem.situations[reading.row]);
  }
  candidate.columns = candidate.columns * candidate.scale.asDiagonal();
  candidate.effect = std::move(effect);
  return candidate;
}

EffectColumns side_by_side(const std::vector<Candidate>& candidates, Eigen::Index rows, std::size_t without) {
  Eigen::Index total = 0;
  for (std::size_t k = 0; k < candidates.size(); ++k)
    if (k != without) total += candidates[k].columns.cols();
  EffectColumns all{Eigen::MatrixXd(rows, total), Eigen::VectorXd::Zero(total)};
  Eigen::Index at = 0;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (k == without) continue;
    const Candidate& c = candidates[k];
    all.columns.middleCols(at, c.columns.cols()) = c.columns;
    if (c.precision.size() > 0) all.precision.segment(at, c.columns.cols()) = c.precision;
    at += c.columns.cols();
  }
  return all;
}

EffectColumns with_one_more(EffectColumns first, const Candidate& candidate) {
  const Eigen::Index before = first.columns.cols(), more = candidate.columns.cols();
  first.columns.conservativeResize(Eigen::NoChange, before + more);
  first.columns.rightCols(more) = candidate.columns;
  first.precision.conservativeResize(before + more);
  first.precision.tail(more).setZero();
  if (candidate.precision.size() > 0) first.precision.tail(more) = candidate.precision;
  return first;
}

VisibleSpace visible_space(const Eigen::MatrixXd& gram_z, const Eigen::MatrixXd& gram_pz) {
  VisibleSpace space{.whitening = Eigen::MatrixXd(gram_z.rows(), 0)};
  const double total = gram_z.trace();
  if (total <= 0) return space;
  space.visible_fraction = std::sqrt(std::max(0.0, gram_pz.trace() / total));
  if (gram_z.rows() == 1) {
    if (gram_pz(0, 0) > kVisible * kVisible * gram_z(0, 0))
      space.whitening = Eigen::MatrixXd::Constant(1, 1, 1 / std::sqrt(gram_pz(0, 0)));
    return space;
  }
  const Eigen::VectorXd unit =
      gram_z.diagonal().unaryExpr([](double square) { return square > 0 ? 1 / std::sqrt(square) : 0.0; });
  const Eigen::MatrixXd gram = unit.asDiagonal() * gram_pz * unit.asDiagonal();
  const SymmetricEigen eigen(gram);
  Eigen::Index first = 0;  // eigenvalues ascend
  while (first < gram.rows() && eigen.eigenvalues()[first] <= kVisible * kVisible) ++first;
  const Eigen::Index kept = gram.rows() - first;
  space.whitening = unit.asDiagonal() * eigen.eigenvectors().rightCols(kept) *
                    eigen.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  return space;
}

CandidateScore score_in(const VisibleSpace& space, const Eigen::VectorXd& product, const Projection& base) {
  CandidateScore s{.rank = static_cast<double>(space.whitening.cols()), .visible_fraction = space.visible_fraction};
  if (s.rank == 0 || base.freedom() <= s.rank) {
    s.rank = 0;
    return s;
  }
  s.gain = (space.whitening.transpose() * product).squaredNorm();
  const double rest = std::max(1e-12 * base.residual_square(), base.residual_square() - s.gain);
  s.p_value = f_tail(s.gain / s.rank / (rest / (base.freedom() - s.rank)), s.rank, base.freedom() - s.rank);
  return s;
}

CandidateScore score(const Projection& base, const Eigen::MatrixXd& columns) {
  const Eigen::MatrixXd used = base.mask().asDiagonal() * columns, reduced = base.reduced(columns);
  const Eigen::MatrixXd gram = used.transpose() * used;
  return score_in(visible_space(gram, gram - reduced.transpose() * reduced), columns.transpose() * base.residual(),
                  base);
}

double evidence(const CandidateScore& s, const Projection& base, double members) {
  return 0.5 * s.gain - 0.5 * s.rank * std::log(std::max(2.0, base.freedom())) - std::log(members);
}

Candidate refined(const LinearProblem& problem, const Projection& base, const Candidate& candidate) {
  return ShapeClimb(problem, base, candidate).run();
}

}  // namespace trunnion
