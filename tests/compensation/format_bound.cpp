#include "format_bound.h"

#include <Eigen/Geometry>
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <functional>
#include <vector>

namespace trunnion::compensation_test {
namespace {

constexpr double kEngaged_mm = 20;

/// A piecewise linear function at x: two nodes and their weights.
struct Hat {
  Eigen::Index node[2];
  double weight[2];
};

class Nodes {
 public:
  Nodes(double low, double high, double step, bool repeats)
      : low_(low),
        cells_(static_cast<Eigen::Index>(std::ceil((high - low) / step - 1e-9))),
        step_((high - low) / static_cast<double>(cells_)),
        repeats_(repeats) {}
  Eigen::Index size() const { return repeats_ ? cells_ : cells_ + 1; }
  Eigen::Index cells() const { return cells_; }
  double at(double cell) const { return low_ + cell * step_; }
  Hat hat(double x) const {
    const double u = (x - low_) / step_;
    const auto cell = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::floor(u)), 0, cells_ - 1);
    const double into = u - static_cast<double>(cell);
    return {{cell, (cell + 1) % size()}, {1 - into, into}};
  }

 private:
  double low_;
  Eigen::Index cells_;
  double step_;
  bool repeats_;
};

/// What one unknown moves: X, Y, Z in mm, A and C in rad.
using Motion = Eigen::Matrix<double, 5, 1>;
using Visit = std::function<void(Eigen::Index unknown, const Motion& moves)>;

class Best : public PlayedCompensation {
 public:
  Best(const Format& format, const Machine& machine, const WorkingVolume& volume, double spacing_deg)
      : format_(format),
        tilt_(machine.tilt()),
        turn_(machine.turn()),
        over_a_(volume.a.low.in_degrees(), volume.a.high.in_degrees(), spacing_deg, false),
        over_c_(0, 360, spacing_deg, true) {
    tilt_.direction.normalize();
    turn_.direction.normalize();
    Eigen::Index n = 0;
    each({}, [&](Eigen::Index unknown, const Motion&) { n = std::max(n, unknown + 1); });
    // One pose names the unknowns of its own cell only; the layout gives the count.
    solved_ = Eigen::VectorXd::Zero(std::max(n, count()));
  }

  void solve(const Model& model, const WorkingVolume& volume) {
    using Triplet = Eigen::Triplet<double>;
    std::vector<Triplet> entries;
    std::vector<double> wanted;
    // Two Gauss points a cell of A and of C; the corners of a tetrahedron have the mean and the variance of the volume.
    const double gauss[2] = {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)};
    const Eigen::Vector3d corners[4] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    const Eigen::Vector3d deviation = volume.variance_mm2().cwiseSqrt();
    for (Eigen::Index i = 0; i < 2 * over_a_.cells(); ++i)
      for (Eigen::Index j = 0; j < 2 * over_c_.cells(); ++j)
        for (const Eigen::Vector3d& corner : corners) {
          Situation s;
          s.at = {Angle::degrees(over_a_.at(static_cast<double>(i / 2) + gauss[i % 2])),
                  Angle::degrees(over_c_.at(static_cast<double>(j / 2) + gauss[j % 2]))};
          s.point_r_mm = volume.centre_mm() + deviation.cwiseProduct(corner);
          s.tool_length_mm = volume.tool_length.in_millimetres();
          const PoseError e = relative_error(model, s);
          const Eigen::Vector3d d = e.translation_mm + e.rotation_rad.cross(s.point_r_mm);
          const auto row = static_cast<int>(wanted.size());
          for (Eigen::Index k = 0; k < 3; ++k) wanted.push_back(-d[k]);
          for (Eigen::Index k = 0; k < 2; ++k) wanted.push_back(-kEngaged_mm * e.rotation_rad[k]);
          const auto both = axes(s);
          const Eigen::Vector3d about_a = both.first, about_c = both.second;
          const Eigen::Vector3d a_moves = about_a.cross(s.point_r_mm - tilt_.origin_mm),
                                c_moves = about_c.cross(s.point_r_mm - turn_place(s));
          each(s, [&](Eigen::Index unknown, const Motion& moves) {
            Eigen::Matrix<double, 5, 1> left;
            left.head<3>() = -moves.head<3>() + moves[3] * a_moves + moves[4] * c_moves;
            left.tail<2>() = kEngaged_mm * (moves[3] * about_a + moves[4] * about_c).head<2>();
            for (int k = 0; k < 5; ++k)
              if (left[k] != 0) entries.emplace_back(row + k, static_cast<int>(unknown), left[k]);
          });
        }
    Eigen::SparseMatrix<double> matrix(static_cast<Eigen::Index>(wanted.size()), solved_.size());
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::Map<const Eigen::VectorXd> right(wanted.data(), static_cast<Eigen::Index>(wanted.size()));
    // Each unknown in its own size; what two of them say alike is shared.
    Eigen::VectorXd scale(solved_.size());
    for (Eigen::Index k = 0; k < scale.size(); ++k) scale[k] = 1 / std::max(matrix.col(k).norm(), 1e-12);
    matrix = (matrix * scale.asDiagonal()).eval();
    Eigen::SparseMatrix<double> normal = matrix.transpose() * matrix;
    for (Eigen::Index k = 0; k < scale.size(); ++k) normal.coeffRef(k, k) += 1e-9;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
    solved_ = scale.cwiseProduct(solver.solve(matrix.transpose() * right));
  }

  AxisCorrection at(const Situation& s) const override {
    Motion sum = Motion::Zero();
    each(s, [&](Eigen::Index unknown, const Motion& moves) { sum += solved_[unknown] * moves; });
    return {sum.head<3>(), sum[3], sum[4]};
  }

 private:
  Eigen::Index count() const {
    const Eigen::Index a = over_a_.size(), c = over_c_.size();
    return (format_.pairs ? 5 * a * c : 0) + (format_.levers ? 9 * (a + c) : 0) + (format_.own_axes ? a + c : 0) +
           (format_.chain ? 6 * (a + c) : 0) + (format_.places ? 6 : 0) + (format_.directions ? 6 : 0);
  }
  Eigen::Matrix3d tilted(const Situation& s) const {
    return Eigen::AngleAxisd(s.at.a.in_radians(), tilt_.direction).toRotationMatrix();
  }
  Eigen::Vector3d turn_place(const Situation& s) const {
    return tilt_.origin_mm + tilted(s) * (turn_.origin_mm - tilt_.origin_mm);
  }
  std::pair<Eigen::Vector3d, Eigen::Vector3d> axes(const Situation& s) const {
    return {tilt_.direction, tilted(s) * turn_.direction};
  }

  void each(const Situation& s, const Visit& visit) const {
    const Hat a = over_a_.hat(s.at.a.in_degrees());
    double c_deg = s.at.c.in_degrees();
    c_deg -= 360 * std::floor(c_deg / 360);
    const Hat c = over_c_.hat(c_deg);
    const Eigen::Index rows = over_a_.size(), columns = over_c_.size();
    Eigen::Index base = 0;
    const auto over_tilt = [&](const Motion& moves) {
      for (int i = 0; i < 2; ++i) visit(base + a.node[i], a.weight[i] * moves);
      base += rows;
    };
    const auto over_turn = [&](const Motion& moves) {
      for (int j = 0; j < 2; ++j) visit(base + c.node[j], c.weight[j] * moves);
      base += columns;
    };
    const auto shift = [](const Eigen::Vector3d& v) {
      Motion m = Motion::Zero();
      m.head<3>() = v;
      return m;
    };
    if (format_.pairs)
      for (Eigen::Index output = 0; output < 5; ++output, base += rows * columns)
        for (int i = 0; i < 2; ++i)
          for (int j = 0; j < 2; ++j)
            visit(base + a.node[i] * columns + c.node[j], a.weight[i] * c.weight[j] * Motion::Unit(output));
    for (Eigen::Index k = 0; k < 3; ++k)
      for (Eigen::Index output = 0; output < 3; ++output)
        if (format_.levers)
          over_tilt(s.point_r_mm[k] * Motion::Unit(output)), over_turn(s.point_r_mm[k] * Motion::Unit(output));
    if (format_.own_axes) {
      over_tilt(Motion::Unit(3));
      over_turn(Motion::Unit(4));
    }
    const Eigen::Matrix3d r = tilted(s);
    const Eigen::Matrix3d whole = r * Eigen::AngleAxisd(s.at.c.in_radians(), turn_.direction).toRotationMatrix();
    // A shift or a turn about the axis' own place, in the frame before its motion; X, Y, Z go where the work goes.
    for (Eigen::Index k = 0; k < 6 && format_.chain; ++k) {
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(k % 3);
      over_tilt(shift(k < 3 ? unit : unit.cross(s.point_r_mm - tilt_.origin_mm)));
      over_turn(shift(r * (k < 3 ? unit : unit.cross(r.transpose() * (s.point_r_mm - turn_place(s))))));
    }
    // Errors that stand still: before the motion, and against it where it starts from.
    const Eigen::Vector3d w = whole.transpose() * (s.point_r_mm - turn_place(s)) + turn_.origin_mm;
    for (Eigen::Index k = 0; k < 6; ++k) {
      if (k < 3 ? !format_.places : !format_.directions) continue;
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(k % 3);
      const auto of = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& origin) {
        return k < 3 ? unit : Eigen::Vector3d(unit.cross(p - origin));
      };
      const Eigen::Vector3d on_tilt = r.transpose() * (s.point_r_mm - tilt_.origin_mm) + tilt_.origin_mm;
      visit(base++, shift(of(s.point_r_mm, tilt_.origin_mm) - r * of(on_tilt, tilt_.origin_mm)));
      visit(base++, shift(r * of(on_tilt, turn_.origin_mm) - whole * of(w, turn_.origin_mm)));
    }
  }

  Format format_;
  Axis tilt_, turn_;
  Nodes over_a_, over_c_;
  Eigen::VectorXd solved_;
};

}  // namespace

std::unique_ptr<PlayedCompensation> best_of(const Format& format, const Machine& machine, const Model& model,
                                            const WorkingVolume& volume, double spacing_deg) {
  auto best = std::make_unique<Best>(format, machine, volume, spacing_deg);
  best->solve(model, volume);
  return best;
}

}  // namespace trunnion::compensation_test
