#include "testpiece/tool_path.h"

#include <cmath>
#include <numbers>

#include "error.h"
#include "units/angle.h"

namespace trunnion {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kUpright = 1e-12;         ///< sine of the inclination below which C means nothing
constexpr double kFinestStep_rad = 1e-11;  ///< of phi, where C swings

Vector3d tool_axis_w(const KinematicChain& chain, IndexedPosition at) {
  return chain.r_from_w(at).linear().transpose() * (chain.r_from_t(at).linear() * Vector3d::UnitZ());
}

/// From one position to the next, with as many between them as C's motion asks for.
class PathBuilder {
 public:
  PathBuilder(const TestPiece& piece, const KinematicChain& chain, Angle largest_turn, Rulings rulings)
      : piece_(piece), chain_(chain), rulings_(std::move(rulings)), largest_(largest_turn.in_radians()) {
    // Where the tool starts upright, C starts where the motion that follows wants it.
    const double ahead = upright(0) ? 1e-6 * piece.sense : 0;
    const Angle c = rotary_position_along(chain_, ruling(ahead), Angle()).c;
    // One turn of C for all who compute it: from -360 (left out) to 0 deg.
    append(0, Angle::radians(c.in_radians() - kTurn_rad * std::ceil(c.in_radians() / kTurn_rad - 1e-9)));
  }

  void advance_to(double phi) {
    const ToolPosition& last = path_.back();
    const double from = last.phi_rad, c = last.at.c.in_radians();
    const double next = rotary_position_along(chain_, ruling(phi), last.at.c).c.in_radians();
    if (std::abs(next - c) <= largest_) {
      append(phi, Angle::radians(next));
    } else if (std::abs(phi - from) > kFinestStep_rad) {
      advance_to(from + (phi - from) / 2);
      advance_to(phi);
    } else {
      swing(phi, next);
    }
  }

  std::vector<ToolPosition> take() { return std::move(path_); }

 private:
  Vector3d ruling(double phi) const { return rulings_(Angle::radians(phi)).ruling_w; }
  bool upright(double phi) const { return ruling(phi).head<2>().norm() < kUpright; }

  /// C turns with the tool upright; half a turn goes on in the sense in which C came.
  void swing(double phi, double next) {
    const double from = path_.back().at.c.in_radians();
    double way = next - from;
    if (std::abs(std::abs(way) - std::numbers::pi) < 1e-3 && way * last_turn() < 0)
      way -= std::copysign(kTurn_rad, way);
    const int steps = static_cast<int>(std::ceil(std::abs(way) / largest_));
    for (int k = 1; k <= steps; ++k) append(phi, Angle::radians(from + way * k / steps));
  }

  double last_turn() const {
    for (std::size_t i = path_.size(); i-- > 1;)
      if (const double d = (path_[i].at.c - path_[i - 1].at.c).in_radians(); std::abs(d) > 1e-12) return d;
    return 0;
  }

  void append(double phi, Angle c) {
    const ConePoint base = rulings_(Angle::radians(phi));
    ToolPosition position{.phi_rad = phi};
    position.nominal.axis_w = base.ruling_w;
    position.nominal.tip_w_mm = base.point_w_mm + 0.5 * piece_.tool.diameter.in_millimetres() * base.normal_w -
                                piece_.tool.overhang.in_millimetres() * base.ruling_w;
    position.at = {rotary_position_along(chain_, base.ruling_w, c).a, c};
    position.tip_r_mm = chain_.r_from_w(position.at) * position.nominal.tip_w_mm;
    path_.push_back(position);
  }

  const TestPiece& piece_;
  const KinematicChain& chain_;
  Rulings rulings_;
  double largest_;
  std::vector<ToolPosition> path_;
};

}  // namespace

IndexedPosition rotary_position_along(const KinematicChain& chain, const Vector3d& axis_w, Angle near_c) {
  // The inclination of the tool against the table is |A|, whichever side carries the axes; C turns it about W's Z.
  const double inclination = std::atan2(axis_w.head<2>().norm(), axis_w.z());
  IndexedPosition at{Angle::radians(-inclination), near_c};
  if (axis_w.head<2>().norm() >= kUpright) {
    const auto azimuth = [](const Vector3d& v) { return std::atan2(v.y(), v.x()); };
    // In which sense growing C turns the tool's direction in W: against itself if the table turns, along if the tool.
    const RotaryJoint& turn = chain.rotary_joints()[chain.turn_index()];
    const double sense = (turn.side == Side::workpiece ? -1 : 1) * (turn.direction.z() < 0 ? -1 : 1);
    const double at_zero = azimuth(tool_axis_w(chain, {at.a, Angle()}));
    const double c = sense * (azimuth(axis_w) - at_zero);
    at.c = Angle::radians(near_c.in_radians() + std::remainder(c - near_c.in_radians(), kTurn_rad));
  }
  if ((tool_axis_w(chain, at) - axis_w).norm() > 1e-9)
    throw ModelError("the rotary axes of this machine cannot put the tool along every ruling of the cone");
  return at;
}

Vector3d slides_mm(const KinematicChain& chain, const Vector3d& tip_r_mm, IndexedPosition at, Length tool_length) {
  return tip_r_mm - chain.r_from_t(at) * Vector3d(0, 0, -tool_length.in_millimetres());
}

void set_senses(std::vector<ToolPosition>& path, const KinematicChain& chain, Length tool_length, Length rounding) {
  constexpr double kStill_rad = 1e-10;
  const double still_mm = rounding.in_millimetres();
  const auto axes = [&](const ToolPosition& p) {
    Eigen::Matrix<double, 5, 1> q;
    q << slides_mm(chain, p.tip_r_mm, p.at, tool_length), p.at.a.in_radians(), p.at.c.in_radians();
    return q;
  };
  if (path.empty()) return;
  Eigen::Matrix<int, 5, 1> sense = Eigen::Matrix<int, 5, 1>::Zero();
  std::vector<Eigen::Matrix<int, 5, 1>> senses(path.size(), sense);
  Eigen::Matrix<double, 5, 1> from = axes(path[0]);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Matrix<double, 5, 1> to = axes(path[i]);
    for (Eigen::Index k = 0; k < 5; ++k)
      if (const double way = to[k] - from[k]; way * sense[k] > 0 || std::abs(way) > (k < 3 ? still_mm : kStill_rad))
        sense[k] = way > 0 ? 1 : -1, from[k] = to[k];
    senses[i] = sense;
  }
  // Before an axis first moves it stands as if it had come the way it then goes on.
  for (Eigen::Index k = 0; k < 5; ++k)
    for (std::size_t i = path.size() - 1; i-- > 0;)
      if (senses[i][k] == 0) senses[i][k] = senses[i + 1][k];
  for (std::size_t i = 0; i < path.size(); ++i) {
    path[i].linear_sense = senses[i].head<3>().cast<double>();
    path[i].tilt_sense = senses[i][3] < 0 ? -1 : 1;
    path[i].turn_sense = senses[i][4] < 0 ? -1 : 1;
  }
}

void set_times(std::vector<ToolPosition>& path, const TestPiece& piece) {
  if (!piece.feed_mm_per_min) return;
  for (std::size_t i = 1; i < path.size(); ++i)
    path[i].time_s = path[i - 1].time_s +
                     (path[i].nominal.tip_w_mm - path[i - 1].nominal.tip_w_mm).norm() * 60 / *piece.feed_mm_per_min;
}

Rulings formula_rulings(const ConeFrustum& cone) {
  return [cone, frame = w_from_cone(cone)](Angle phi) { return cone_point(cone, frame, phi, Length()); };
}

std::vector<ToolPosition> flank_milling_path(const TestPiece& piece, const KinematicChain& chain,
                                             const PathSampling& sampling, Rulings rulings) {
  const int per_point = (sampling.steps_per_turn + piece.points - 1) / piece.points;
  const int steps = per_point * piece.points;
  if (!rulings) rulings = formula_rulings(piece.cone);
  PathBuilder builder(piece, chain, sampling.largest_turn, std::move(rulings));
  for (int k = 1; k <= steps; ++k) builder.advance_to(piece.sense * kTurn_rad * k / steps);
  std::vector<ToolPosition> path = builder.take();
  set_senses(path, chain, piece.tool.length);
  set_times(path, piece);
  return path;
}

}  // namespace trunnion
