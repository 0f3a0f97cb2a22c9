#include "compensation/lost_terms.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "geometric_errors/symbol.h"
#include "model/joint_motion.h"

namespace trunnion {
namespace {

constexpr int kTilts = 9, kTurns = 18;
constexpr double kWorthSaying = 0.01;  // of the largest
constexpr double kWorthSaying_mm = 0.001e-3;

/// The deviations left at four tips: corners of a tetrahedron with the mean and the variance of the volume.
class Corners {
 public:
  explicit Corners(const WorkingVolume& volume) : centre_(volume.centre_mm()), variance_(volume.variance_mm2()) {
    const Eigen::Vector3d deviation = variance_.cwiseSqrt();
    const std::array<Eigen::Vector3d, 4> signs = {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
    for (std::size_t k = 0; k < 4; ++k) arms_[k] = deviation.cwiseProduct(signs[k]);
  }
  Eigen::Vector3d tip(std::size_t k) const { return centre_ + arms_[k]; }

  /// The twist at R's origin nearest to displacements of the four tips.
  Vector6d twist(const std::array<Eigen::Vector3d, 4>& moved) const {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k) mean += moved[k] / 4, moment += arms_[k].cross(moved[k]) / 4;
    Vector6d t;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double arm = variance_.sum() - variance_[k];
      t[3 + k] = arm > 0 ? moment[k] / arm : 0;
    }
    t.head<3>() = mean - t.tail<3>().cross(centre_);
    return t;
  }
  Eigen::Vector3d displacement(const Vector6d& twist, std::size_t k) const {
    return twist.head<3>() + twist.tail<3>().cross(tip(k));
  }
  double mean_square(const Vector6d& twist) const {
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += displacement(twist, k).squaredNorm() / 4;
    return sum;
  }

 private:
  Eigen::Vector3d centre_, variance_;
  std::array<Eigen::Vector3d, 4> arms_;
};

/// Mean squares of what is no error of A or of C at a place of its own.
struct Rest {
  double linear = 0, tilt_sense = 0, turn_sense = 0;
};

}  // namespace

std::vector<LostTerm> lost_terms(const CompensationTask& task, const PlayedCompensation& played) {
  const char a = task.machine.tilt_letter();
  const Corners corners(task.volume);
  const auto place = [](Range<Angle> range, int k, int count) {
    return range.low + ((k + 0.5) / count) * (range.high - range.low);
  };
  std::vector<Vector6d> twists(static_cast<std::size_t>(kTilts * kTurns));
  Rest rest;
  for (int i = 0; i < kTilts; ++i)
    for (int j = 0; j < kTurns; ++j) {
      std::array<Eigen::Vector3d, 4> mean, of_tilt, of_turn;
      for (std::size_t k = 0; k < 4; ++k) {
        Situation s;
        s.at = {place(task.volume.a, i, kTilts), place(task.volume.c, j, kTurns)};
        s.point_r_mm = corners.tip(k);
        s.tool_length_mm = task.volume.tool_length.in_millimetres();
        const auto left = [&](int tilt_sense, int turn_sense) {
          s.tilt_sense = tilt_sense;
          s.turn_sense = turn_sense;
          return remaining(task.model, task.chain, s, played.at(s)).position_mm;
        };
        const Eigen::Vector3d both = left(1, 1), down = left(-1, 1), back = left(1, -1);
        of_tilt[k] = 0.5 * (down - both);
        of_turn[k] = 0.5 * (back - both);
        mean[k] = both + of_tilt[k] + of_turn[k];
      }
      Vector6d& t = twists[static_cast<std::size_t>(i * kTurns + j)];
      t = corners.twist(mean);
      constexpr double kShare = 1.0 / (4 * kTilts * kTurns);
      for (std::size_t k = 0; k < 4; ++k) {
        rest.linear += kShare * (mean[k] - corners.displacement(t, k)).squaredNorm();
        rest.tilt_sense += kShare * of_tilt[k].squaredNorm();
        rest.turn_sense += kShare * of_turn[k].squaredNorm();
      }
    }

  std::array<double, 6> of_tilt{}, of_turn{};
  for (int i = 0; i < kTilts; ++i) {
    Situation s;
    s.at = {place(task.volume.a, i, kTilts), Angle()};
    const Matrix6d from_tilt = joint_twist(task.chain, task.chain.tilt_index(), s),
                   from_turn = joint_twist(task.chain, task.chain.turn_index(), s);
    const Matrix6d to_tilt = from_tilt.inverse(), to_turn = from_turn.inverse();
    Vector6d mean = Vector6d::Zero();
    for (int j = 0; j < kTurns; ++j) mean += twists[static_cast<std::size_t>(i * kTurns + j)] / kTurns;
    const auto add = [&](std::array<double, 6>& sum, const Matrix6d& from, const Vector6d& error, double share) {
      for (Eigen::Index k = 0; k < 6; ++k)
        sum[static_cast<std::size_t>(k)] += share * corners.mean_square(from.col(k) * error[k]);
    };
    add(of_tilt, from_tilt, to_tilt * mean, 1.0 / kTilts);
    for (int j = 0; j < kTurns; ++j)
      add(of_turn, from_turn, to_turn * (twists[static_cast<std::size_t>(i * kTurns + j)] - mean),
          1.0 / (kTilts * kTurns));
  }

  std::vector<LostTerm> terms;
  for (std::size_t k = 0; k < 6; ++k) {
    terms.push_back({error_symbol(k, a), std::sqrt(of_tilt[k])});
    terms.push_back({error_symbol(k, 'C'), std::sqrt(of_turn[k])});
  }
  terms.push_back({"X Y Z", std::sqrt(rest.linear)});
  terms.push_back({std::string(1, a) + "_dir", std::sqrt(rest.tilt_sense)});
  terms.push_back({"C_dir", std::sqrt(rest.turn_sense)});
  std::ranges::stable_sort(terms, std::greater<>(), &LostTerm::position_rms_mm);
  const double least = std::max(kWorthSaying_mm, kWorthSaying * terms.front().position_rms_mm);
  std::erase_if(terms, [&](const LostTerm& term) { return term.position_rms_mm < least; });
  return terms;
}

}  // namespace trunnion
