#include "compensation/projection.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "linear_algebra/factors.h"
#include "model/effects/location_errors.h"
#include "model/joint_motion.h"

namespace trunnion {
namespace {

constexpr double kEngaged_mm = 20;
const double kSteady_mm = kEngaged_mm * std::sin(5 * std::numbers::pi / 180);  // below 5 deg C hardly tilts: no peaks

bool asks_for(const Effect& effect, char axis) {
  const std::string column = std::string(1, static_cast<char>(axis - 'X' + 'x')) + "_mm";
  return std::ranges::count(effect.depends_on(), column) > 0;
}

bool asks_for_linear(const Effect& effect) {
  return asks_for(effect, 'X') || asks_for(effect, 'Y') || asks_for(effect, 'Z');
}

Situation in_the_middle(const CompensationTask& task, IndexedPosition at) {
  Situation s;
  s.at = at;
  s.point_r_mm = task.volume.centre_mm();
  s.tool_length_mm = task.volume.tool_length.in_millimetres();
  return s;
}

}  // namespace

Matrix6d volume_metric(const WorkingVolume& volume) {
  const Eigen::Vector3d variance = volume.variance_mm2();
  const auto at_centre = displacement_jacobian(volume.centre_mm());
  Matrix6d metric = at_centre.transpose() * at_centre;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Matrix3d cross = cross_matrix(Eigen::Vector3d::Unit(k));
    metric.bottomRightCorner<3, 3>() += variance[k] * cross.transpose() * cross;
  }
  metric(3, 3) += kEngaged_mm * kEngaged_mm;
  metric(4, 4) += kEngaged_mm * kEngaged_mm;
  return metric;
}

Matrix6d orientation_metric() {
  Matrix6d metric = Matrix6d::Zero();
  metric(3, 3) = metric(4, 4) = kEngaged_mm * kEngaged_mm;
  metric(5, 5) = kSteady_mm * kSteady_mm;
  return metric;
}

PoseError rotary_part(const CompensationTask& task, IndexedPosition at, int tilt_sense, int turn_sense) {
  Situation s = in_the_middle(task, at);
  s.tilt_sense = tilt_sense;
  s.turn_sense = turn_sense;
  PoseError sum;
  for (const EffectPtr& effect : task.model.effects)
    if (effect->is_compensated() && !asks_for_linear(*effect)) sum += effect->at(s);
  return sum;
}

std::vector<LinearPart> linear_parts(const CompensationTask& task, double step_mm) {
  std::vector<LinearPart> parts;
  const Eigen::Vector3d centre = task.volume.centre_mm();
  const Range<Length> ranges[3] = {task.volume.x, task.volume.y, task.volume.z};
  const Situation middle = in_the_middle(task, {0.5 * (task.volume.a.low + task.volume.a.high), Angle()});
  for (Eigen::Index k = 0; k < 3; ++k) {
    LinearPart part{.axis = static_cast<char>('X' + k)};
    std::vector<EffectPtr> effects;
    for (const EffectPtr& effect : task.model.effects)
      if (effect->is_compensated() && asks_for(*effect, part.axis)) effects.push_back(effect);
    if (effects.empty()) continue;
    part.stations_mm = even_nodes(ranges[k].low.in_millimetres(), ranges[k].high.in_millimetres(), step_mm);
    part.table.assign(part.stations_mm.size(), Vector6d::Zero());
    part.tip.assign(part.stations_mm.size(), Eigen::Vector3d::Zero());
    for (const EffectPtr& effect : effects) {
      bool first_axis = true;
      for (char other = 'X'; other < part.axis; ++other) first_axis = first_axis && !asks_for(*effect, other);
      const auto twist = [&](double along, const Eigen::Vector3d& across) {
        Situation s = middle;
        s.point_r_mm = across;
        s.point_r_mm[k] = along;
        return effect->at(s).vector();
      };
      // An effect of this axis alone gives the same twist wherever the others stand, if it moves the table as a whole.
      const double probe = part.stations_mm.front();
      Eigen::Vector3d elsewhere = centre + Eigen::Vector3d(31, -47, 59);
      const bool whole = twist(probe, centre).isApprox(twist(probe, elsewhere), 1e-9) ||
                         (twist(probe, centre) - twist(probe, elsewhere)).norm() < 1e-12;
      // Its value at the middle counts once, however many axes it asks for.
      const Vector6d counted = first_axis ? Vector6d::Zero().eval() : twist(centre[k], centre);
      for (std::size_t i = 0; i < part.stations_mm.size(); ++i) {
        const Vector6d t = twist(part.stations_mm[i], centre) - counted;
        if (whole) {
          part.table[i] += t;
        } else {
          Eigen::Vector3d p = centre;
          p[k] = part.stations_mm[i];
          part.tip[i] += displacement_jacobian(p) * t;
        }
      }
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

double reversal_rad(const CompensationTask& task, char axis) {
  const bool turn = axis == 'C';
  const std::size_t joint = turn ? task.chain.turn_index() : task.chain.tilt_index();
  const Matrix6d metric = volume_metric(task.volume);
  double moved = 0, weight = 0;
  for (const double u : {0.1, 0.3, 0.5, 0.7, 0.9})
    for (const double v : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const IndexedPosition at{task.volume.a.low + u * (task.volume.a.high - task.volume.a.low),
                               task.volume.c.low + v * (task.volume.c.high - task.volume.c.low)};
      const Vector6d change = (turn ? rotary_part(task, at, 1, -1) : rotary_part(task, at, -1, 1)).vector() -
                              rotary_part(task, at).vector();
      const Vector6d turning = joint_rotation(task.chain, joint, in_the_middle(task, at));
      moved += turning.dot(metric * change);
      weight += turning.dot(metric * turning);
    }
  return moved / weight;
}

OwnAxisFit own_axis_fit(const CompensationTask& task, const Matrix6d& metric, const std::vector<double>& tilt_at_deg,
                        const std::vector<double>& turn_at_deg, const EffectPtr& constants) {
  const auto rows = static_cast<Eigen::Index>(tilt_at_deg.size());
  const auto columns = static_cast<Eigen::Index>(turn_at_deg.size());
  const auto m = constants == nullptr ? Eigen::Index{0} : static_cast<Eigen::Index>(constants->parameters().size());
  // Normal equations of  sum_ij |e_ij + a_ij f_i + c_ij g_j - B_ij x|^2  in the metric. Rows of A are eliminated one by
  // one: what remains is small and dense in g and x.
  const Eigen::Index unknowns = columns + m;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  Eigen::MatrixXd coupling(rows, unknowns);
  Eigen::VectorXd tilt_weight = Eigen::VectorXd::Zero(rows), tilt_right = Eigen::VectorXd::Zero(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    Eigen::RowVectorXd coupled = Eigen::RowVectorXd::Zero(unknowns);
    for (Eigen::Index j = 0; j < columns; ++j) {
      const IndexedPosition at{Angle::degrees(tilt_at_deg[static_cast<std::size_t>(i)]),
                               Angle::degrees(turn_at_deg[static_cast<std::size_t>(j)])};
      const Situation s = in_the_middle(task, at);
      const Vector6d error = rotary_part(task, at).vector();
      const Vector6d a = joint_rotation(task.chain, task.chain.tilt_index(), s);
      Matrix6Xd rest(6, 1 + m);
      rest.col(0) = joint_rotation(task.chain, task.chain.turn_index(), s);
      if (m > 0) {
        rest.rightCols(m) = -constants->basis(s);
        for (Eigen::Index k = 0; k < m; ++k)
          if (constants->parameters()[static_cast<std::size_t>(k)].unit != Unit::um) rest.col(1 + k).setZero();
      }
      tilt_weight[i] += a.dot(metric * a);
      tilt_right[i] -= a.dot(metric * error);
      const Eigen::MatrixXd weighted = rest.transpose() * metric;
      const Eigen::MatrixXd inner = weighted * rest;
      const Eigen::VectorXd outer = weighted * a, wanted = -weighted * error;
      coupled[j] += outer[0];
      coupled.tail(m) += outer.tail(m).transpose();
      normal(j, j) += inner(0, 0);
      normal.block(j, columns, 1, m) += inner.block(0, 1, 1, m);
      normal.block(columns, j, m, 1) += inner.block(1, 0, m, 1);
      normal.bottomRightCorner(m, m) += inner.bottomRightCorner(m, m);
      right[j] += wanted[0];
      right.tail(m) += wanted.tail(m);
    }
    coupling.row(i) = coupled;
    normal -= coupled.transpose() * coupled / tilt_weight[i];
    right -= coupled.transpose() * (tilt_right[i] / tilt_weight[i]);
  }
  normal.diagonal().array() += 1e-9 * normal.diagonal().mean();  // angles that are left out, and f against g
  const Eigen::VectorXd solved = PivotedCholesky(normal).solve(right);
  const Eigen::VectorXd f = (tilt_right - coupling * solved).cwiseQuotient(tilt_weight);
  return {{f.begin(), f.end()}, {solved.begin(), solved.begin() + columns}, solved.tail(m)};
}

PairFit pair_fit(const CompensationTask& task, const std::vector<double>& tilt_at_deg,
                 const std::vector<double>& turn_at_deg, const EffectPtr& followed) {
  using Lever = Eigen::Matrix<double, 9, 1>;  // columns of the lever matrix one below the other
  using Seen = Eigen::Matrix<double, 11, 1>;  // those times the volume's half-widths, and the tilt
  constexpr double kPreferRotary = 1e-6;      // what A or C can do as well is theirs
  constexpr int kMostRounds = 60;
  constexpr double kSettled = 1e-11;  // mm per mm
  const std::size_t rows = tilt_at_deg.size(), columns = turn_at_deg.size();
  const Eigen::Vector3d spread = task.volume.variance_mm2().cwiseSqrt();
  const Eigen::Vector3d centre = task.volume.centre_mm();
  Lever widths;
  for (Eigen::Index k = 0; k < 3; ++k) widths.segment<3>(3 * k).setConstant(spread[k]);
  // How a rotation acts about the volume's centre: the displacement it spreads along each axis, and the tilt.
  const auto seen = [&](const Eigen::Vector3d& rotation) {
    Seen y;
    for (Eigen::Index k = 0; k < 3; ++k) y.segment<3>(3 * k) = spread[k] * rotation.cross(Eigen::Vector3d::Unit(k));
    y.tail<2>() = kEngaged_mm * rotation.head<2>();
    return y;
  };
  struct Place {
    Vector6d error, about_a, about_c;
    Seen asked;
    Eigen::Matrix<double, 11, 2> turning;
    Eigen::Matrix<double, 2, 11> solve;
    Seen left_by_rotary(const Seen& y) const { return y - turning * (solve * y); }
  };
  std::vector<Place> places(rows * columns);
  std::vector<Eigen::Matrix<double, 9, 9>> of_row(rows), of_column(columns);
  const Eigen::Matrix<double, 9, 9> held = kPreferRotary * Eigen::Matrix<double, 9, 9>::Identity();
  std::ranges::fill(of_row, held);
  std::ranges::fill(of_column, held);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const IndexedPosition at{Angle::degrees(tilt_at_deg[i]), Angle::degrees(turn_at_deg[j])};
      const Situation s = in_the_middle(task, at);
      Place& place = places[i * columns + j];
      place.error = rotary_part(task, at).vector();
      place.asked = seen(place.error.tail<3>());
      if (followed != nullptr) {
        const Vector6d carried = followed->at(s).vector();
        place.asked.head<9>() -= seen(carried.tail<3>()).head<9>();
        place.error -= carried;
      }
      place.about_a = joint_rotation(task.chain, task.chain.tilt_index(), s);
      place.about_c = joint_rotation(task.chain, task.chain.turn_index(), s);
      place.turning << seen(place.about_a.tail<3>()), seen(place.about_c.tail<3>());
      Eigen::Matrix2d inner = place.turning.transpose() * place.turning + 1e-9 * Eigen::Matrix2d::Identity();
      inner(1, 1) += kSteady_mm * kSteady_mm;
      place.solve = inner.inverse() * place.turning.transpose();
      // Rotary axes eliminated: what they cannot take is left to the levers.
      Eigen::Matrix<double, 9, 9> normal =
          widths.asDiagonal() * (-place.turning.topRows<9>() * place.solve.leftCols<9>()) * widths.asDiagonal();
      normal.diagonal() += widths.cwiseAbs2();
      of_row[i] += normal;
      of_column[j] += normal;
    }
  std::vector<PivotedCholesky> row_solvers(of_row.begin(), of_row.end()),
      column_solvers(of_column.begin(), of_column.end());
  // Levers of A given those of C and the other way round; where C is carried by A the second round finds nothing new.
  std::vector<Lever> of_tilt(rows, Lever::Zero()), of_turn(columns, Lever::Zero());
  const auto wanted = [&](std::size_t i, std::size_t j, const Lever& other) {
    Seen rest = places[i * columns + j].asked;
    rest.head<9>() -= widths.cwiseProduct(other);
    return Lever(widths.cwiseProduct(places[i * columns + j].left_by_rotary(rest).head<9>()));
  };
  for (int round = 0; round < kMostRounds; ++round) {
    double change = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      Lever right = Lever::Zero();
      for (std::size_t j = 0; j < columns; ++j) right += wanted(i, j, of_turn[j]);
      const Lever now = row_solvers[i].solve(right);
      change = std::max(change, (now - of_tilt[i]).cwiseAbs().maxCoeff());
      of_tilt[i] = now;
    }
    Lever mean = Lever::Zero();
    for (std::size_t j = 0; j < columns; ++j) {
      Lever right = Lever::Zero();
      for (std::size_t i = 0; i < rows; ++i) right += wanted(i, j, of_tilt[i]);
      of_turn[j] = column_solvers[j].solve(right);
      mean += of_turn[j] / static_cast<double>(columns);
    }
    for (Lever& lever : of_turn) lever -= mean;
    for (Lever& lever : of_tilt) lever += mean;
    if (change < kSettled) break;
  }

  PairFit fit;
  const auto n = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  fit.tilt_rad.resize(n(rows), n(columns));
  fit.turn_rad.resize(n(rows), n(columns));
  for (Eigen::MatrixXd& shift : fit.shift_mm) shift.resize(n(rows), n(columns));
  fit.left.resize(11, n(rows * columns));
  for (const Lever& lever : of_tilt) fit.tilt_lever.emplace_back(Eigen::Map<const Eigen::Matrix3d>(lever.data()));
  for (const Lever& lever : of_turn) fit.turn_lever.emplace_back(Eigen::Map<const Eigen::Matrix3d>(lever.data()));
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const Place& place = places[i * columns + j];
      Seen unlevered = place.asked;
      unlevered.head<9>() -= widths.cwiseProduct(of_tilt[i] + of_turn[j]);
      const Eigen::Vector2d turned = -(place.solve * unlevered);
      fit.left.col(n(i * columns + j)) = unlevered + place.turning * turned;
      fit.tilt_rad(n(i), n(j)) = turned[0];
      fit.turn_rad(n(i), n(j)) = turned[1];
      const Vector6d rest = place.error + turned[0] * place.about_a + turned[1] * place.about_c;
      const Eigen::Vector3d shift =
          rest.head<3>() + rest.tail<3>().cross(centre) - (fit.tilt_lever[i] + fit.turn_lever[j]) * centre;
      for (std::size_t k = 0; k < 3; ++k) fit.shift_mm[k](n(i), n(j)) = shift[n(k)];
    }
  return fit;
}

EffectPtr followed_location(const CompensationTask& task) {
  constexpr double kPreferFollowed = 1e-3;  // mean squares: far below what a table could not say
  const EffectPtr location = make_location_errors(effect_context(task.machine));
  const auto n = static_cast<Eigen::Index>(location->parameters().size());
  const std::vector<double> tilt_at = even_nodes(task.volume.a.low.in_degrees(), task.volume.a.high.in_degrees(), 15);
  std::vector<double> turn_at = even_nodes(0, 360, 30);
  turn_at.pop_back();  // the first again
  const PairFit whole = pair_fit(task, tilt_at, turn_at);
  const Model nothing;
  CompensationTask blank(task.machine, nothing, task.options, task.profile.questions());
  blank.volume = task.volume;
  Eigen::MatrixXd left(whole.left.size(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const EffectPtr alone = location->with_parameters(Eigen::VectorXd::Unit(n, k), {});
    left.col(k) = pair_fit(blank, tilt_at, turn_at, alone).left.reshaped();
  }
  Eigen::MatrixXd normal = left.transpose() * left;
  Eigen::VectorXd right = -left.transpose() * whole.left.reshaped();
  const Matrix6d metric = kPreferFollowed * volume_metric(task.volume);
  for (const double tilt : tilt_at)
    for (const double turn : turn_at) {
      const Situation s = in_the_middle(task, {Angle::degrees(tilt), Angle::degrees(turn)});
      const Matrix6Xd basis = location->basis(s);
      normal += basis.transpose() * metric * basis;
      right += basis.transpose() * metric * rotary_part(task, s.at).vector();
    }
  // Lengths in mm and angles in rad: of one size only when scaled.
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  scaled.diagonal().array() += 1e-9;
  return location->with_parameters(scale.asDiagonal() * PivotedCholesky(scaled).solve(scale.asDiagonal() * right), {});
}

ChainFit chain_fit(const CompensationTask& task, const std::vector<double>& tilt_at_deg,
                   const std::vector<double>& turn_at_deg, TurnErrors turn_errors) {
  const std::size_t rows = tilt_at_deg.size(), columns = turn_at_deg.size();
  const Matrix6d metric = volume_metric(task.volume);
  const std::size_t turn_joint = task.chain.turn_index();
  std::vector<Vector6d> errors(rows * columns);
  std::vector<Matrix6d> carried(rows);  // Ad(A): from C's frame to R
  for (std::size_t i = 0; i < rows; ++i) {
    const Angle a = Angle::degrees(tilt_at_deg[i]);
    carried[i] = joint_twist(task.chain, turn_joint, in_the_middle(task, {a, Angle()}));
    for (std::size_t j = 0; j < columns; ++j)
      errors[i * columns + j] = rotary_part(task, {a, Angle::degrees(turn_at_deg[j])}).vector();
  }
  const Matrix6d to_tilt = joint_twist(task.chain, task.chain.tilt_index(), in_the_middle(task, {})).inverse();
  ChainFit fit;
  fit.tilt = Matrix6Xd::Zero(6, static_cast<Eigen::Index>(rows));
  const auto at = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  // The last of a full turn's columns is the first again and would count twice in a mean.
  const std::size_t distinct = columns > 1 ? columns - 1 : columns;
  if (turn_errors == TurnErrors::of_both) {
    fit.turn.resize(6, at(rows * columns));
    for (std::size_t i = 0; i < rows; ++i) {
      for (std::size_t j = 0; j < distinct; ++j)
        fit.tilt.col(at(i)) += errors[i * columns + j] / static_cast<double>(distinct);
      const Matrix6d back = carried[i].inverse();
      for (std::size_t j = 0; j < columns; ++j)
        fit.turn.col(at(i * columns + j)) = back * (errors[i * columns + j] - fit.tilt.col(at(i)));
    }
    fit.tilt = to_tilt * fit.tilt;
    return fit;
  }
  fit.turn = Matrix6Xd::Zero(6, at(columns));
  Matrix6d normal = Matrix6d::Zero();
  for (const Matrix6d& ad : carried) normal += ad.transpose() * metric * ad;
  const PivotedCholesky solver(normal);
  // By turns: a column of C given A's, the mean of A given C's; both are exact, the sum shrinks to the least squares.
  for (int round = 0; round < 100; ++round) {
    const Matrix6Xd before = fit.turn;
    for (std::size_t j = 0; j < columns; ++j) {
      Vector6d right = Vector6d::Zero();
      for (std::size_t i = 0; i < rows; ++i)
        right += carried[i].transpose() * metric * (errors[i * columns + j] - fit.tilt.col(at(i)));
      fit.turn.col(at(j)) = solver.solve(right);
    }
    for (std::size_t i = 0; i < rows; ++i) {
      fit.tilt.col(at(i)).setZero();
      for (std::size_t j = 0; j < distinct; ++j)
        fit.tilt.col(at(i)) +=
            (errors[i * columns + j] - carried[i] * fit.turn.col(at(j))) / static_cast<double>(distinct);
    }
    if ((fit.turn - before).lpNorm<Eigen::Infinity>() < 1e-13) break;
  }
  fit.tilt = to_tilt * fit.tilt;
  return fit;
}

}  // namespace trunnion
