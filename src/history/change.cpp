#include "history/change.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "identification/distributions.h"
#include "identification/whitening.h"
#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

constexpr double kExplained = 0.01;  // what is left is noise at this p
constexpr double kCredible = 0.95;

/// A time function that a change may follow.
struct Shape {
  bool drift = false;
  std::size_t from = 0;  ///< the last point before
  double at(std::size_t k, const std::vector<double>& t) const {
    if (!drift) return k > from ? 1 : 0;
    return std::max(0.0, t[k] - t[from]);
  }
  friend auto operator<=>(const Shape&, const Shape&) = default;
};

/// A change that is in the fit, or tried: which mode, when.
struct Term {
  std::size_t mode = 0;
  Shape shape;
};

/// The points in directions in which the mean covariance is 1, the constant mu eliminated.
class WhiteProblem {
 public:
  WhiteProblem(const ChangeProblem& problem, std::span<const double> years) {
    const std::vector<ErrorSeries::Point>& points = problem.points;
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(points[0].covariance.rows(), points[0].covariance.cols());
    for (const ErrorSeries::Point& point : points) mean += point.covariance / static_cast<double>(points.size());
    const Eigen::MatrixXd white = whitening(mean);
    rank_ = white.rows();
    sum_ = Eigen::MatrixXd::Zero(rank_, rank_);
    rhs_ = Eigen::VectorXd::Zero(rank_);
    for (const ErrorSeries::Point& point : points) {
      t_.push_back(years[point.calibration]);
      y_.push_back(white * point.values);
      // Directions that a calibration knows much better than the mean keep a floor: rounding, not knowledge.
      constexpr double kFloor = 1e-6;
      Eigen::MatrixXd spread = white * point.covariance * white.transpose();
      spread.diagonal().array() += kFloor;
      precision_.push_back(Cholesky(spread).inverse());
      sum_ += precision_.back();
      rhs_ += precision_.back() * y_.back();
      chi_square_ += y_.back().dot(precision_.back() * y_.back());
    }
    factor_ = PivotedCholesky(sum_);
    chi_square_ -= rhs_.dot(factor_.solve(rhs_));
    for (const ChangeMode& mode : problem.modes) modes_.push_back(visible(white * mode.design));
  }

  std::size_t size() const { return y_.size(); }
  const std::vector<double>& times() const { return t_; }
  std::size_t modes() const { return modes_.size(); }
  /// Visible coefficients of a mode.
  Eigen::Index count(std::size_t mode) const { return modes_[mode].in_white.cols(); }
  double chi_square() const { return chi_square_; }
  double freedom(const std::vector<Term>& terms) const {
    double left = static_cast<double>(rank_) * (static_cast<double>(size()) - 1);
    for (const Term& term : terms) left -= static_cast<double>(count(term.mode));
    return left;
  }

  struct Fit {
    double gain = 0;             ///< of chi-square
    Eigen::VectorXd solution;    ///< visible coefficients of each term in turn
    Eigen::MatrixXd covariance;  ///< of them
  };
  Fit fit(const std::vector<Term>& terms) const {
    std::vector<Eigen::Index> first;
    Eigen::Index n = 0;
    for (const Term& term : terms) first.push_back(std::exchange(n, n + count(term.mode)));
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(n);
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const Eigen::MatrixXd& x = modes_[terms[i].mode].in_white;
      rhs.segment(first[i], x.cols()) = x.transpose() * moment(terms[i].shape);
      for (std::size_t j = 0; j <= i; ++j) {
        const Eigen::MatrixXd& z = modes_[terms[j].mode].in_white;
        const Eigen::MatrixXd block = x.transpose() * product(terms[i].shape, terms[j].shape) * z;
        normal.block(first[i], first[j], x.cols(), z.cols()) = block;
        normal.block(first[j], first[i], z.cols(), x.cols()) = block.transpose();
      }
    }
    // Two shapes of one mode may be all but the same: a ridge far below any information keeps the factor.
    normal.diagonal() *= 1 + 1e-12;
    const PivotedCholesky factor(normal);
    Fit fit{.solution = factor.solve(rhs)};
    fit.gain = rhs.dot(fit.solution);
    fit.covariance = factor.solve(Eigen::MatrixXd::Identity(n, n));
    return fit;
  }

  /// The change of the values per visible coefficient of a mode, and the coefficients that it stands for.
  const Eigen::MatrixXd& coefficients(std::size_t mode) const { return modes_[mode].coefficients; }

 private:
  /// A mode in whitened space, on the combinations of its coefficients that can be seen.
  struct Visible {
    Eigen::MatrixXd in_white;      ///< orthonormal columns times their size
    Eigen::MatrixXd coefficients;  ///< of the mode, one column per visible one
  };
  static Visible visible(const Eigen::MatrixXd& design) {
    constexpr double kSeen = 1e-6;  // of the best seen, in standard uncertainties
    const SymmetricEigen eigen(design.transpose() * design);
    const Eigen::Index n = design.cols();
    Eigen::Index first = 0;
    while (first < n && eigen.eigenvalues()[first] <= kSeen * kSeen * eigen.eigenvalues()[n - 1]) ++first;
    Visible v{.coefficients = eigen.eigenvectors().rightCols(n - first)};
    v.coefficients *= eigen.eigenvalues().tail(n - first).cwiseSqrt().cwiseInverse().asDiagonal();
    v.in_white = design * v.coefficients;
    return v;
  }

  Eigen::MatrixXd weighted_sum(const Shape& shape) const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(rank_, rank_);
    for (std::size_t k = 0; k < size(); ++k)
      if (const double g = shape.at(k, t_); g != 0) sum += g * precision_[k];
    return sum;
  }
  /// sum g g' P - (sum g P) (sum P)^-1 (sum g' P)
  const Eigen::MatrixXd& product(const Shape& a, const Shape& b) const {
    Eigen::MatrixXd& cached = products_[{a, b}];
    if (cached.size() != 0) return cached;
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(rank_, rank_);
    for (std::size_t k = 0; k < size(); ++k)
      if (const double g = a.at(k, t_) * b.at(k, t_); g != 0) sum += g * precision_[k];
    return cached = sum - weighted_sum(a) * factor_.solve(weighted_sum(b));
  }
  /// sum g P y - (sum g P) (sum P)^-1 (sum P y)
  Eigen::VectorXd moment(const Shape& shape) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(rank_);
    for (std::size_t k = 0; k < size(); ++k)
      if (const double g = shape.at(k, t_); g != 0) sum += g * (precision_[k] * y_[k]);
    return sum - weighted_sum(shape) * factor_.solve(rhs_);
  }

  Eigen::Index rank_ = 0;
  std::vector<double> t_;
  std::vector<Eigen::VectorXd> y_;
  std::vector<Eigen::MatrixXd> precision_;
  Eigen::MatrixXd sum_;
  Eigen::VectorXd rhs_;
  PivotedCholesky factor_;
  double chi_square_ = 0;
  std::vector<Visible> modes_;
  mutable std::map<std::pair<Shape, Shape>, Eigen::MatrixXd> products_;
};

/// Every step, and every rate that does not look the same as a step.
std::vector<Shape> shapes_of(const WhiteProblem& problem) {
  std::vector<Shape> shapes;
  for (std::size_t from = 0; from + 1 < problem.size(); ++from) {
    // Calibrations of the same moment cannot be told apart.
    if (problem.times()[from + 1] <= problem.times()[from]) continue;
    shapes.push_back({.drift = false, .from = from});
    if (from + 2 < problem.size()) shapes.push_back({.drift = true, .from = from});
  }
  return shapes;
}

double survival(double chi_square, double freedom) { return freedom > 0 ? chi_square_tail(chi_square, freedom) : 1; }

/// What is left after `terms`, over what the uncertainties say; 1 where it is noise.
double scatter2(const WhiteProblem& problem, const std::vector<Term>& terms, double gain) {
  const double left = problem.chi_square() - gain, freedom = problem.freedom(terms);
  return survival(left, freedom) < kExplained ? left / freedom : 1;
}

/// log of the probability that noise gains as much by `term` in addition to `terms`.
double log_tail(double gain, double count, double scatter, double freedom) {
  const double chi_square = gain / scatter;
  const double tail = scatter > 1 ? f_tail(chi_square / count, count, freedom) : chi_square_tail(chi_square, count);
  if (tail > 1e-280) return std::log(tail);
  // Q(a, x) ~ x^(a-1) e^-x / Gamma(a) for large x
  const double a = 0.5 * count, x = 0.5 * chi_square;
  return (a - 1) * std::log(x) - x - std::lgamma(a);
}

struct Addition {
  Term term;
  double log_p = 0;
};

/// The likeliest addition. Candidates are compared in one scatter, the least that any of them leaves: with a scatter of
/// its own each, the one with most coefficients would win wherever only it is enough for the rest to pass for noise.
/// How likely noise is to do as much as the chosen one is told in that one's own.
Addition best_addition(const WhiteProblem& problem, const std::vector<Shape>& shapes, const std::vector<Term>& terms) {
  struct Candidate {
    Term term;
    double gain, count, scatter, freedom;
    double log_p(double in_scatter) const { return log_tail(gain, count, in_scatter, freedom); }
  };
  const double before = problem.fit(terms).gain;
  std::vector<Candidate> tried;
  for (std::size_t mode = 0; mode < problem.modes(); ++mode)
    for (const Shape& shape : shapes) {
      std::vector<Term> with = terms;
      with.push_back({mode, shape});
      const double gain = problem.fit(with).gain, freedom = problem.freedom(with);
      if (problem.count(mode) == 0 || freedom < 0) continue;
      tried.push_back({with.back(), std::max(0.0, gain - before), static_cast<double>(problem.count(mode)),
                       scatter2(problem, with, gain), freedom});
    }
  if (tried.empty()) return {};
  const double common = std::ranges::min(tried, {}, &Candidate::scatter).scatter;
  const Candidate& best =
      *std::ranges::min_element(tried, {}, [common](const Candidate& c) { return c.log_p(common); });
  return {best.term, std::min(0.0, best.log_p(best.scatter) + std::log(static_cast<double>(tried.size())))};
}

/// The times of the terms found anew, one after the other, the others being what they are.
void settle(const WhiteProblem& problem, const std::vector<Shape>& shapes, std::vector<Term>& terms) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    bool moved = false;
    for (Term& term : terms) {
      double best = problem.fit(terms).gain;
      const Shape was = term.shape;
      Shape found = was;
      for (const Shape& shape : shapes) {
        term.shape = shape;
        if (const double gain = problem.fit(terms).gain; gain > best + 1e-9) best = gain, found = shape;
      }
      term.shape = found;
      moved = moved || found != was;
    }
    if (!moved) return;
  }
}

/// When it began, if it is a change of this kind: the fewest moments that share 95 % of the likelihood.
void find_moment(Change& change, const WhiteProblem& problem, const std::vector<Shape>& shapes, std::vector<Term> terms,
                 std::size_t index, double scatter) {
  std::vector<std::pair<double, std::size_t>> likely;
  for (const Shape& shape : shapes) {
    if (shape.drift != change.drift) continue;
    terms[index].shape = shape;
    likely.emplace_back(problem.fit(terms).gain / (scatter * scatter), shape.from);
  }
  std::ranges::sort(likely, std::ranges::greater{});
  double all = 0, sum = 0;
  for (const auto& [gain, from] : likely) all += std::exp(0.5 * (gain - likely.front().first));
  change.earliest = change.latest = change.from;
  for (const auto& [gain, from] : likely) {
    change.earliest = std::min(change.earliest, from);
    change.latest = std::max(change.latest, from);
    if ((sum += std::exp(0.5 * (gain - likely.front().first))) >= kCredible * all) return;
  }
}

}  // namespace

CourseFinding find_changes(const ChangeProblem& given, std::span<const double> years, double level) {
  CourseFinding finding;
  if (given.points.size() < 2) return finding;
  const WhiteProblem problem(given, years);
  const std::vector<Shape> shapes = shapes_of(problem);
  std::vector<Term> terms;
  std::vector<double> log_p;
  finding.p_value = survival(problem.chi_square(), problem.freedom({}));
  for (;;) {
    const Addition addition = best_addition(problem, shapes, terms);
    if (addition.log_p >= std::log(level)) break;
    terms.push_back(addition.term);
    log_p.push_back(addition.log_p);
    settle(problem, shapes, terms);
  }
  const WhiteProblem::Fit fit = problem.fit(terms);
  finding.left_p_value = survival(problem.chi_square() - fit.gain, problem.freedom(terms));
  finding.scatter = std::sqrt(std::max(1.0, scatter2(problem, terms, fit.gain)));
  Eigen::Index first = 0;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const ChangeMode& mode = given.modes[terms[i].mode];
    const Shape& shape = terms[i].shape;
    Change change{.error = mode.name,
                  .unit = mode.unit,
                  .places = mode.places,
                  .drift = shape.drift,
                  .from = shape.from,
                  .to = shape.drift ? problem.size() - 1 : shape.from + 1,
                  .p_value = std::exp(log_p[i])};
    find_moment(change, problem, shapes, terms, i, finding.scatter);
    const Eigen::Index n = problem.count(terms[i].mode);
    Eigen::MatrixXd shown = problem.coefficients(terms[i].mode);
    if (mode.shown.size() != 0) shown = mode.shown * mode.design * shown;
    change.amount = shown * fit.solution.segment(first, n);
    change.std =
        finding.scatter *
        (shown * fit.covariance.block(first, first, n, n) * shown.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
    Eigen::Index largest = 0;
    change.amount.cwiseAbs().cwiseQuotient(change.std.cwiseMax(std::numeric_limits<double>::min())).maxCoeff(&largest);
    change.largest = static_cast<std::size_t>(largest);
    finding.changes.push_back(std::move(change));
    first += n;
  }
  std::ranges::stable_sort(finding.changes, {}, &Change::from);
  return finding;
}

ChangeProblem single_problem(const ErrorSeries& series) {
  return {.points = series.points,
          .modes = {{.name = series.name, .unit = series.unit, .design = Eigen::MatrixXd::Identity(1, 1)}}};
}

Difference difference(const ErrorSeries& series) {
  const ErrorSeries::Point &first = series.points.front(), &last = series.points.back();
  const Eigen::VectorXd moved = last.values - first.values;
  const Eigen::MatrixXd covariance = first.covariance + last.covariance;
  const Eigen::VectorXd white = whitening(covariance) * moved;
  Eigen::Index k = 0;
  moved.cwiseAbs2().cwiseQuotient(covariance.diagonal().cwiseMax(std::numeric_limits<double>::min())).maxCoeff(&k);
  return {.largest = static_cast<std::size_t>(k),
          .before = first.values[k],
          .before_std = std::sqrt(std::max(0.0, first.covariance(k, k))),
          .after = last.values[k],
          .after_std = std::sqrt(std::max(0.0, last.covariance(k, k))),
          .p_value = white.size() == 0 ? 1 : chi_square_tail(white.squaredNorm(), static_cast<double>(white.size()))};
}

namespace {

/// Log likelihood of a random walk seen with noise, with a free start: Kalman filter of one number.
double walk_log_likelihood(const ErrorSeries& series, std::span<const double> years, double variance_per_year) {
  double sum = 0, mean = 0, variance = 0;
  for (std::size_t k = 0; k < series.points.size(); ++k) {
    const ErrorSeries::Point& point = series.points[k];
    const double noise = point.covariance(0, 0);
    if (k == 0) {
      mean = point.values[0];
      variance = noise;
      continue;
    }
    variance += variance_per_year * (years[point.calibration] - years[series.points[k - 1].calibration]);
    const double innovation = point.values[0] - mean, spread = variance + noise;
    sum -= 0.5 * (innovation * innovation / spread + std::log(spread));
    mean += variance / spread * innovation;
    variance *= noise / spread;
  }
  return sum;
}

}  // namespace

WanderingRate wandering_rate(std::span<const ErrorSeries> series, std::span<const double> years) {
  constexpr double kOneSided90 = 0.5 * 1.2815515655446004 * 1.2815515655446004;  // of the log likelihood
  constexpr int kSteps = 4000;
  double noise2 = 0, count = 0;
  for (const ErrorSeries& one : series)
    for (std::size_t k = 1; k < one.points.size(); ++k) noise2 += one.points[k].covariance(0, 0), ++count;
  if (count == 0 || noise2 <= 0) return {0, std::numeric_limits<double>::infinity()};
  // Rates from far below what the noise lets see to far above, in equal ratios.
  const double unit = std::sqrt(noise2 / count);
  const auto rate = [&](int k) { return unit * std::exp(std::log(1e-3) + std::log(1e8) * k / kSteps); };
  std::vector<double> likelihood;
  for (int k = 0; k <= kSteps; ++k) {
    double sum = 0;
    for (const ErrorSeries& one : series) sum += walk_log_likelihood(one, years, rate(k) * rate(k));
    likelihood.push_back(sum);
  }
  const auto best = static_cast<int>(std::ranges::max_element(likelihood) - likelihood.begin());
  int most = best;
  while (most < kSteps &&
         likelihood[static_cast<std::size_t>(most)] > likelihood[static_cast<std::size_t>(best)] - kOneSided90)
    ++most;
  return {best == 0 ? 0 : rate(best), rate(most)};
}

}  // namespace trunnion
