#include "history/change.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "identification/distributions.h"
#include "identification/whitening.h"

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
  friend bool operator==(const Shape&, const Shape&) = default;
};

/// The points in directions in which the mean covariance is 1.
class WhiteSeries {
 public:
  WhiteSeries(const ErrorSeries& series, std::span<const double> years) {
    Eigen::MatrixXd mean =
        Eigen::MatrixXd::Zero(series.points[0].covariance.rows(), series.points[0].covariance.cols());
    for (const ErrorSeries::Point& point : series.points)
      mean += point.covariance / static_cast<double>(series.points.size());
    white_ = whitening(mean);
    back_ = mean * white_.transpose();  // the pseudo-inverse of the whitening
    for (const ErrorSeries::Point& point : series.points) {
      t_.push_back(years[point.calibration]);
      y_.push_back(white_ * point.values);
      // Directions that a calibration knows much better than the mean keep a floor: rounding, not knowledge.
      constexpr double kFloor = 1e-6;
      Eigen::MatrixXd spread = white_ * point.covariance * white_.transpose();
      spread.diagonal().array() += kFloor;
      precision_.push_back(spread.llt().solve(Eigen::MatrixXd::Identity(spread.rows(), spread.cols())));
    }
  }

  Eigen::Index rank() const { return white_.rows(); }
  std::size_t size() const { return y_.size(); }
  const std::vector<double>& times() const { return t_; }
  const Eigen::MatrixXd& back() const { return back_; }

  struct Fit {
    double chi_square = 0;
    Eigen::VectorXd solution;    ///< mu, then beta of each shape
    Eigen::MatrixXd covariance;  ///< of it
  };
  Fit fit(const std::vector<Shape>& shapes) const {
    const Eigen::Index r = rank(), blocks = 1 + static_cast<Eigen::Index>(shapes.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(r * blocks, r * blocks);
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(r * blocks);
    double square = 0;
    for (std::size_t k = 0; k < size(); ++k) {
      Eigen::VectorXd g = Eigen::VectorXd::Ones(blocks);
      for (Eigen::Index i = 1; i < blocks; ++i) g[i] = shapes[static_cast<std::size_t>(i - 1)].at(k, t_);
      const Eigen::VectorXd weighted = precision_[k] * y_[k];
      square += y_[k].dot(weighted);
      for (Eigen::Index i = 0; i < blocks; ++i) {
        rhs.segment(i * r, r) += g[i] * weighted;
        for (Eigen::Index j = 0; j < blocks; ++j) normal.block(i * r, j * r, r, r) += g[i] * g[j] * precision_[k];
      }
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
    Fit fit{.solution = factor.solve(rhs)};
    fit.covariance = factor.solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
    fit.chi_square = std::max(0.0, square - rhs.dot(fit.solution));
    return fit;
  }

  /// Degrees of freedom left by so many shapes.
  double freedom(std::size_t shapes) const {
    return static_cast<double>(rank()) * (static_cast<double>(size()) - 1 - static_cast<double>(shapes));
  }

 private:
  Eigen::MatrixXd white_, back_;
  std::vector<double> t_;
  std::vector<Eigen::VectorXd> y_;
  std::vector<Eigen::MatrixXd> precision_;
};

/// Every step, and every rate that does not look the same as a step, that is not in use.
std::vector<Shape> candidates(const WhiteSeries& series, const std::vector<Shape>& used) {
  std::vector<Shape> shapes;
  for (std::size_t from = 0; from + 1 < series.size(); ++from) {
    shapes.push_back({.drift = false, .from = from});
    if (from + 2 < series.size()) shapes.push_back({.drift = true, .from = from});
  }
  // Calibrations of the same moment cannot be told apart.
  std::erase_if(shapes, [&](const Shape& shape) {
    return std::ranges::find(used, shape) != used.end() ||
           (shape.drift ? series.times().back() : series.times()[shape.from + 1]) <= series.times()[shape.from];
  });
  return shapes;
}

double survival(double chi_square, double freedom) { return freedom > 0 ? chi_square_tail(chi_square, freedom) : 1; }

/// One more shape, and how sure it is.
struct Addition {
  Shape shape;
  double p_value = 1;
  std::vector<std::pair<Shape, double>> weights;  ///< of the shapes of its kind: how likely each is
};

Addition best_addition(const WhiteSeries& series, const std::vector<Shape>& used) {
  const double before = series.fit(used).chi_square;
  const std::vector<Shape> tried = candidates(series, used);
  Addition best;
  if (tried.empty()) return best;
  std::vector<double> left;
  for (const Shape& shape : tried) {
    std::vector<Shape> with = used;
    with.push_back(shape);
    left.push_back(series.fit(with).chi_square);
  }
  const auto found = static_cast<std::size_t>(std::ranges::min_element(left) - left.begin());
  best.shape = tried[found];
  const double freedom = series.freedom(used.size() + 1), gained = before - left[found];
  const auto rank = static_cast<double>(series.rank());
  const bool scatters = survival(left[found], freedom) < kExplained;
  const double scale = scatters ? left[found] / freedom : 1;
  const double tail = scatters ? f_tail(gained / rank / scale, rank, freedom) : chi_square_tail(gained, rank);
  best.p_value = std::min(1.0, tail * static_cast<double>(tried.size()));
  double sum = 0;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    if (tried[k].drift != best.shape.drift) continue;
    best.weights.emplace_back(tried[k], std::exp(-0.5 * (left[k] - left[found]) / scale));
    sum += best.weights.back().second;
  }
  for (auto& [shape, weight] : best.weights) weight /= sum;
  return best;
}

Change change_of(const Addition& addition, const WhiteSeries& series) {
  Change change{.drift = addition.shape.drift,
                .from = addition.shape.from,
                .to = addition.shape.drift ? series.size() - 1 : addition.shape.from + 1,
                .p_value = addition.p_value};
  std::vector<std::pair<Shape, double>> likely = addition.weights;
  std::ranges::sort(likely, std::ranges::greater{}, [](const auto& entry) { return entry.second; });
  change.earliest = change.latest = change.from;
  double sum = 0;
  for (const auto& [shape, weight] : likely) {
    change.earliest = std::min(change.earliest, shape.from);
    change.latest = std::max(change.latest, shape.from);
    if ((sum += weight) >= kCredible) break;
  }
  return change;
}

}  // namespace

SeriesFinding find_changes(const ErrorSeries& series, std::span<const double> years, double level) {
  SeriesFinding finding;
  if (series.points.size() < 2) return finding;
  const WhiteSeries white(series, years);
  if (white.rank() == 0) return finding;
  std::vector<Shape> shapes;
  double left = white.fit({}).chi_square;
  finding.p_value = finding.left_p_value = survival(left, white.freedom(0));
  const std::size_t most = std::max<std::size_t>(1, (white.size() - 1) / 2);
  while (shapes.size() < most) {
    if (!shapes.empty() && finding.left_p_value >= kExplained) break;
    const Addition addition = best_addition(white, shapes);
    if (addition.p_value >= level) break;
    shapes.push_back(addition.shape);
    finding.changes.push_back(change_of(addition, white));
    left = white.fit(shapes).chi_square;
    finding.left_p_value = survival(left, white.freedom(shapes.size()));
  }
  const double freedom = white.freedom(shapes.size());
  if (finding.left_p_value < std::min(kExplained, level)) finding.scatter = std::sqrt(std::max(1.0, left / freedom));
  finding.course = !shapes.empty() ? Course::changed : finding.scatter > 1 ? Course::scatters : Course::steady;
  const WhiteSeries::Fit fit = white.fit(shapes);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    Change& change = finding.changes[i];
    const Eigen::Index r = white.rank(), first = r * static_cast<Eigen::Index>(i + 1);
    change.amount = white.back() * fit.solution.segment(first, r);
    const Eigen::MatrixXd covariance =
        white.back() * fit.covariance.block(first, first, r, r) * white.back().transpose();
    change.std = finding.scatter * covariance.diagonal().cwiseMax(0).cwiseSqrt();
    Eigen::Index largest = 0;
    change.amount.cwiseAbs().cwiseQuotient(change.std.cwiseMax(std::numeric_limits<double>::min())).maxCoeff(&largest);
    change.largest = static_cast<std::size_t>(largest);
  }
  std::ranges::sort(finding.changes, {}, &Change::from);
  return finding;
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
