#include "compensation/projection.h"

#include <algorithm>
#include <cmath>

#include "model/joint_motion.h"

namespace trunnion {
namespace {

constexpr double kEngaged_mm = 20;

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

PoseError rotary_part(const CompensationTask& task, IndexedPosition at, int tilt_sense, int turn_sense) {
  Situation s = in_the_middle(task, at);
  s.tilt_sense = tilt_sense;
  s.turn_sense = turn_sense;
  PoseError sum;
  for (const EffectPtr& effect : task.model.effects)
    if (effect->origin() == Origin::machine && !asks_for_linear(*effect)) sum += effect->at(s);
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
      if (effect->origin() == Origin::machine && asks_for(*effect, part.axis)) effects.push_back(effect);
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

OwnAxisFit own_axis_fit(const CompensationTask& task, const std::vector<double>& tilt_at_deg,
                        const std::vector<double>& turn_at_deg) {
  const Matrix6d metric = volume_metric(task.volume);
  const auto rows = static_cast<Eigen::Index>(tilt_at_deg.size());
  const auto columns = static_cast<Eigen::Index>(turn_at_deg.size());
  // Normal equations of  sum_ij |e_ij + a_ij f_i + c_ij g_j|^2  in the metric, solved by turns: f given g, g given f.
  Eigen::MatrixXd aa(rows, columns), ac(rows, columns), cc(rows, columns), ae(rows, columns), ce(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j) {
      const IndexedPosition at{Angle::degrees(tilt_at_deg[static_cast<std::size_t>(i)]),
                               Angle::degrees(turn_at_deg[static_cast<std::size_t>(j)])};
      const Situation s = in_the_middle(task, at);
      const Vector6d error = metric * rotary_part(task, at).vector();
      const Vector6d a = joint_rotation(task.chain, task.chain.tilt_index(), s);
      const Vector6d c = joint_rotation(task.chain, task.chain.turn_index(), s);
      aa(i, j) = a.dot(metric * a), ac(i, j) = a.dot(metric * c), cc(i, j) = c.dot(metric * c);
      ae(i, j) = a.dot(error), ce(i, j) = c.dot(error);
    }
  Eigen::VectorXd f = Eigen::VectorXd::Zero(rows), g = Eigen::VectorXd::Zero(columns);
  for (int round = 0; round < 200; ++round) {
    const Eigen::VectorXd before = f;
    f = -((ae + ac * g.asDiagonal()).rowwise().sum()).cwiseQuotient(aa.rowwise().sum());
    g = -((ce + f.asDiagonal() * ac).colwise().sum().transpose()).cwiseQuotient(cc.colwise().sum().transpose());
    if ((f - before).lpNorm<Eigen::Infinity>() < 1e-13) break;
  }
  return {{f.begin(), f.end()}, {g.begin(), g.end()}};
}

}  // namespace trunnion
