#include "postproc/correction.h"

#include <algorithm>
#include <cmath>

#include "error.h"

namespace trunnion {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDerivativeStep_rad =
    1e-4;                                 // errors change over tenths of a radian: 1e-9 of them is lost to curvature
constexpr double kConverged_rad = 1e-6;   // a step leaves a thousandth of itself, errors of a milliradian granted
constexpr int kMostSteps = 8;             // two do unless the errors are absurd
constexpr double kUnlimited_rad = 1e-13;  // what of a change of C its limit may take without a second look

constexpr double kAbsurdTurn_rad = 1;
constexpr double kNear_rad = 5e-4;    // second order: 30 um of six waves a turn lose 0.0002 um
constexpr double kSmall_rad = 0.005;  // its seventh power is beyond double precision

/// Sine and one minus cosine of a small angle, short series. Products of constants: a division costs more than all the
/// rest.
struct SineVersine {
  double sine, versine;
};
inline SineVersine of_small(double angle) {
  const double square = angle * angle;
  return {angle * (1 - square * (1.0 / 6) * (1 - square * (1.0 / 20))),
          0.5 * square * (1 - square * (1.0 / 12) * (1 - square * (1.0 / 30)))};
}

/// `v` turned by `angle` about the unit vector `axis` (Rodrigues). Corrections are small.
inline Vector3d turned(const Vector3d& v, const Vector3d& axis, double angle) {
  SineVersine of;
  if (std::abs(angle) < kSmall_rad) {
    of = of_small(angle);
  } else {
    const double half = std::sin(0.5 * angle);
    of = {std::sin(angle), 2 * half * half};
  }
  const Vector3d across = axis.cross(v);
  return v + of.sine * across + of.versine * axis.cross(across);
}

struct SineCosine {
  double sine, cosine;
};
inline SineCosine sine_cosine(double angle) {
  if (std::abs(angle) >= kSmall_rad) return {std::sin(angle), std::cos(angle)};
  const SineVersine of = of_small(angle);
  return {of.sine, 1 - of.versine};
}

/// Rx(a) Ry(b) Rz(c): the rotation of a pose error.
inline Matrix3d rotation(const Vector3d& rotation_rad) {
  const auto [sa, ca] = sine_cosine(rotation_rad.x());
  const auto [sb, cb] = sine_cosine(rotation_rad.y());
  const auto [sc, cc] = sine_cosine(rotation_rad.z());
  Matrix3d r;
  r << cb * cc, -cb * sc, sb,                                    //
      ca * sc + sa * sb * cc, ca * cc - sa * sb * sc, -sa * cb,  //
      sa * sc - ca * sb * cc, sa * cc + ca * sb * sc, ca * cb;
  return r;
}

/// `value` for |value| << `limit`, `limit` at most, without a corner between.
double saturated(double value, double limit) {
  if (limit <= 0) return 0;
  const double ratio2 = (value / limit) * (value / limit);
  const double ratio8 = ratio2 * ratio2 * ratio2 * ratio2;
  return value / std::sqrt(std::sqrt(std::sqrt(1 + ratio8)));
}

/// Whether saturated() takes less than kUnlimited_rad: an eighth of the ratio's eighth power, told without roots.
bool far_below(double value, double limit) {
  const double square = value * value, power4 = square * square, limit2 = limit * limit, limit4 = limit2 * limit2;
  return std::abs(value) * power4 * power4 < 8 * kUnlimited_rad * limit4 * limit4;
}

/// Changes of the tilting and of the turning axis, rad.
struct Turned {
  double tilt = 0, turn = 0;
  double largest() const { return std::max(std::abs(tilt), std::abs(turn)); }
};

/// The tool axis and the wanted axis near one programmed rotary position, the errors linear in (dA, dC).
class AxisMismatch {
 public:
  AxisMismatch(const KinematicChain& chain, const Vector3d& tool, const Vector3d (&lines)[2], const Vector3d& error,
               const Vector3d& error_by_a, const Vector3d& error_by_c)
      : error_rotation_(rotation(error)),
        error_by_a_(error_by_a),
        error_by_c_(error_by_c),
        tool_(tool),
        lines_{lines[0], lines[1]},
        tilt_(chain.tilt_index()) {
    for (std::size_t i = 0; i < 2; ++i) {
      of_workpiece_[i] = chain.rotary_joints()[i].side == Side::workpiece;
      const Vector3d sweep = lines_[i].cross(tool_);
      (i == tilt_ ? by_tilt : by_turn) = of_workpiece_[i] ? sweep : Vector3d(-sweep);
    }
  }

  /// d(v - z)/dA and d(v - z)/dC of the nominal machine at zero, at right angles to the tool axis: a C parallel to the
  /// tool moves nothing.
  Vector3d by_tilt, by_turn;
  /// The same with the errors' own derivative.
  Vector3d all_by_tilt() const { return by_tilt + error_by_a_.cross(tool_); }
  Vector3d all_by_turn() const { return by_turn + error_by_c_.cross(tool_); }

  /// v - z, rad.
  Vector3d mismatch() const { return error_rotation_ * tool_ - tool_; }
  Vector3d mismatch(const Turned& by) const {
    // The error's own change is a thousandth of a small angle: first order will do, beyond 1e-10 rad.
    Vector3d wanted = error_rotation_ * moved(by, Side::workpiece);
    wanted += (error_by_a_ * by.tilt + error_by_c_ * by.turn).cross(wanted);
    return wanted - moved(by, Side::tool);
  }
  /// The angle that a mismatch is: its part across the tool axis.
  double angle(const Vector3d& mismatch) const { return (mismatch - tool_ * tool_.dot(mismatch)).norm(); }

 private:
  /// The tool axis direction carried along by the joints of one side: the inner joint turns first.
  Vector3d moved(const Turned& by, Side side) const {
    Vector3d v = tool_;
    for (std::size_t i = 2; i-- > 0;)
      if (of_workpiece_[i] == (side == Side::workpiece)) v = turned(v, lines_[i], i == tilt_ ? by.tilt : by.turn);
    return v;
  }

  Matrix3d error_rotation_;
  Vector3d error_by_a_, error_by_c_;
  Vector3d tool_;
  Vector3d lines_[2];
  bool of_workpiece_[2];
  std::size_t tilt_;
};

}  // namespace

ErrorField::Slopes ErrorField::with_slopes(const Situation& situation) const {
  const Angle step = Angle::radians(kDerivativeStep_rad);
  const PoseError here = at(situation);
  const auto slope = [&](Angle a, Angle c) {
    Situation near = situation;
    near.at = {a, c};
    const PoseError there = at(near);
    return PoseError{(there.translation_mm - here.translation_mm) / kDerivativeStep_rad,
                     (there.rotation_rad - here.rotation_rad) / kDerivativeStep_rad};
  };
  return {here, slope(situation.at.a + step, situation.at.c), slope(situation.at.a, situation.at.c + step)};
}

Corrector::Corrector(const KinematicChain& chain, const ErrorField& field, CorrectionSettings settings)
    : chain_(chain), field_(field), settings_(settings), tool_side_(chain.has_rotary(Side::tool)) {
  const double damping = std::sin(settings.damping.in_radians());
  damping2_ = damping * damping;
  for (std::size_t i = 0; i < 2; ++i) {
    cross_[i] = cross_matrix(chain.rotary_joints()[i].direction);
    cross2_[i] = cross_[i] * cross_[i];
    at_zero_[i] = chain.rotary_joints()[i].origin_mm.isZero(0);
  }
}

Corrector::Turns Corrector::turns(IndexedPosition position) const {
  Turns turns;
  for (std::size_t i = 0; i < 2; ++i) {
    const double angle = (i == chain_.tilt_index() ? position.a : position.c).in_radians();
    turns.sine[i] = std::sin(angle);
    turns.cosine[i] = std::cos(angle);
  }
  return turns;
}

Corrector::Stand Corrector::stand(const Turns& turns) const {
  Stand at;
  at.w_rotation = at.t_rotation = Matrix3d::Identity();
  at.w_origin = at.t_origin = Vector3d::Zero();
  bool turned[2] = {false, false};  // workpiece, tool
  for (std::size_t i = 0; i < 2; ++i) {
    const RotaryJoint& joint = chain_.rotary_joints()[i];
    const Matrix3d motion = Matrix3d::Identity() + turns.sine[i] * cross_[i] + (1 - turns.cosine[i]) * cross2_[i];
    const bool table = joint.side == Side::workpiece;
    Matrix3d& rotation = table ? at.w_rotation : at.t_rotation;
    bool& carried = turned[table ? 0 : 1];
    Vector3d& origin = table ? at.w_origin : at.t_origin;
    at.lines[i] = carried ? Vector3d(rotation * joint.direction) : joint.direction;
    at.pivots[i] = origin;
    if (!at_zero_[i]) {
      const Vector3d pivot = rotation * joint.origin_mm;
      at.pivots[i] += pivot;
      origin += pivot - rotation * (motion * joint.origin_mm);
    }
    rotation = carried ? Matrix3d(rotation.lazyProduct(motion)) : motion;
    carried = true;
  }
  return at;
}

Vector3d Corrector::tip_r(const Commanded& programmed, const Stand& at) const {
  if (settings_.tcp == ToolCentrePoint::on) return at.w_rotation * programmed.xyz_mm + at.w_origin;
  if (!tool_side_) return programmed.xyz_mm;
  const Vector3d tool(0, 0, -settings_.tool_length_mm);
  return programmed.xyz_mm + at.t_rotation * tool + at.t_origin - tool;
}

Vector3d Corrector::slides_mm(const Vector3d& tip_r_mm, IndexedPosition rotary) const {
  if (!tool_side_) return tip_r_mm;
  const Stand at = stand(rotary);
  const Vector3d tool(0, 0, -settings_.tool_length_mm);
  return tip_r_mm - (at.t_rotation * tool + at.t_origin - tool);
}

Vector3d Corrector::tip_w(const Commanded& programmed, const Stand& at) const {
  if (settings_.tcp == ToolCentrePoint::on) return programmed.xyz_mm;
  return at.w_rotation.transpose() * (tip_r(programmed, at) - at.w_origin);
}

Vector3d Corrector::nominal_tip_w(const Commanded& programmed) const {
  return tip_w(programmed, stand(programmed.rotary));
}

Vector3d Corrector::nominal_tip_r(const Commanded& programmed) const {
  return tip_r(programmed, stand(programmed.rotary));
}

Situation Corrector::situation(const Commanded& programmed, IndexedPosition position, const Vector3d& tip_r_mm) const {
  Situation situation;
  situation.at = position;
  situation.point_r_mm = tip_r_mm;
  situation.tilt_sense = programmed.tilt_sense;
  situation.turn_sense = programmed.turn_sense;
  for (std::size_t i = 0; i < 3; ++i) situation.linear_sense[static_cast<Eigen::Index>(i)] = programmed.linear_sense[i];
  situation.time_s = programmed.time_s;
  situation.tool_length_mm = settings_.tool_length_mm;
  return situation;
}

RotaryCorrection Corrector::rotary(const Commanded& programmed) const {
  if (settings_.orientation == Orientation::as_programmed) return {};
  const Stand here = stand(programmed.rotary);
  return rotary(here, field_.with_slopes(situation(programmed, programmed.rotary, tip_r(programmed, here))));
}

RotaryCorrection Corrector::rotary(const Stand& here, const ErrorField::Slopes& slopes) const {
  const AxisMismatch axes(chain_, here.t_rotation.col(2), here.lines, slopes.error.rotation_rad,
                          slopes.by_a.rotation_rad, slopes.by_c.rotation_rad);

  // Stationary point J~^T m(q) + diag(0, lambda^2) dq = 0 by Newton with the derivative J at zero. J~ is the nominal
  // one, so that a C parallel to the tool keeps its programmed value.
  const Vector3d all_by_tilt = axes.all_by_tilt(), all_by_turn = axes.all_by_turn();
  const double tilt_tilt = axes.by_tilt.dot(all_by_tilt), tilt_turn = axes.by_tilt.dot(all_by_turn);
  const double turn_tilt = axes.by_turn.dot(all_by_tilt), turn_turn = axes.by_turn.dot(all_by_turn) + damping2_;
  const double scale = 1 / (tilt_tilt * turn_turn - tilt_turn * turn_tilt);
  Turned q;
  Vector3d left = axes.mismatch();
  for (int i = 0; i < kMostSteps; ++i) {
    if (i > 0) left = axes.mismatch(q);
    const double tilt = axes.by_tilt.dot(left), turn = axes.by_turn.dot(left) + damping2_ * q.turn;
    const Turned change{scale * (turn_turn * tilt - tilt_turn * turn), scale * (tilt_tilt * turn - turn_tilt * tilt)};
    q.tilt -= change.tilt;
    q.turn -= change.turn;
    // What the step leaves, to its own second order.
    left -= change.tilt * all_by_tilt + change.turn * all_by_turn;
    if (change.largest() < kConverged_rad) break;
  }
  const double limit = settings_.largest_rotary_change.in_radians();
  const double limited = far_below(q.turn, limit) ? q.turn : saturated(q.turn, limit);
  if (!(std::abs(limited - q.turn) < kUnlimited_rad)) {
    // The tilting axis, undamped, at the C that is left.
    q.turn = limited;
    for (int i = 0; i < kMostSteps; ++i) {
      left = axes.mismatch(q);
      const double change = axes.by_tilt.dot(left) / tilt_tilt;
      q.tilt -= change;
      if (std::abs(change) < kConverged_rad) break;
    }
  }
  return {Angle::radians(q.tilt), Angle::radians(q.turn), Angle::radians(axes.angle(left))};
}

Corrector::Linear Corrector::linear(const Commanded& programmed, IndexedPosition rotary) const {
  const Stand there = stand(rotary);
  const bool needs_meant = settings_.tcp == ToolCentrePoint::off && !(rotary == programmed.rotary);
  return linear(programmed, rotary, needs_meant ? stand(programmed.rotary) : there, there, std::nullopt);
}

/// `known`: the error at `rotary`, where it is.
Corrector::Linear Corrector::linear(const Commanded& programmed, IndexedPosition rotary, const Stand& meant,
                                    const Stand& there, const std::optional<PoseError>& known) const {
  const bool moved = !(rotary == programmed.rotary);
  const bool on = settings_.tcp == ToolCentrePoint::on;
  // Where tip and workpiece point are brought together: at the nominal place of the wanted point, the table at
  // `rotary`.
  Vector3d tip;
  if (on) {
    tip = there.w_rotation * programmed.xyz_mm + there.w_origin;
  } else if (!moved) {
    tip = tip_r(programmed, there);
  } else {
    const Vector3d nominal = tip_r(programmed, meant);
    tip = there.w_rotation * (meant.w_rotation.transpose() * (nominal - meant.w_origin)) + there.w_origin;
  }
  Linear result;
  result.error = known ? *known : error_at(programmed, rotary, tip);
  const Vector3d deviation = rotation(result.error.rotation_rad) * tip - tip + result.error.translation_mm;
  result.deviation_mm = deviation.norm();
  result.tip_r_mm = tip + deviation;
  if (on) {
    result.change_mm = there.w_rotation.transpose() * deviation;
  } else {
    // X Y Z that bring the tip to where the wanted point is, the head at `rotary`.
    const Commanded same{programmed.xyz_mm, rotary};
    result.change_mm = deviation + tip - (tool_side_ ? tip_r(same, there) : programmed.xyz_mm);
    if (!moved) result.change_mm = deviation;
  }
  return result;
}

Corrector::Solved Corrector::solve(const Commanded& programmed, int tilt_decimals, int turn_decimals,
                                   bool rotary_moves) const {
  const Stand here = stand(programmed.rotary);
  Solved solved;
  solved.rotary = programmed.rotary;
  solved.tilt_deg = {0, tilt_decimals};
  solved.turn_deg = {0, turn_decimals};
  if (!rotary_moves || settings_.orientation == Orientation::as_programmed) {
    solved.linear = linear(programmed, solved.rotary, here, here, std::nullopt);
    return solved;
  }
  const Vector3d tip = tip_r(programmed, here);
  const ErrorField::Slopes slopes = field_.with_slopes(situation(programmed, programmed.rotary, tip));
  solved.turn = rotary(here, slopes);
  if (!(std::abs(solved.turn.da.in_radians()) <= kAbsurdTurn_rad) ||
      !(std::abs(solved.turn.dc.in_radians()) <= kAbsurdTurn_rad))
    throw RangeError("the model gives no usable correction of the rotary axes here");
  solved.tilt_deg = rounded(solved.turn.da.in_degrees(), tilt_decimals);
  solved.turn_deg = rounded(solved.turn.dc.in_degrees(), turn_decimals);
  solved.tilt_by = Angle::degrees(solved.tilt_deg.value());
  solved.turn_by = Angle::degrees(solved.turn_deg.value());
  if (solved.tilt_deg.mantissa != 0) solved.rotary.a = programmed.rotary.a + solved.tilt_by;
  if (solved.turn_deg.mantissa != 0) solved.rotary.c = programmed.rotary.c + solved.turn_by;
  std::optional<PoseError> error;
  const double a = solved.tilt_by.in_radians(), c = solved.turn_by.in_radians();
  if (slopes.smooth && std::abs(a) < kNear_rad && std::abs(c) < kNear_rad) {
    error = slopes.error;
    error->translation_mm += a * slopes.by_a.translation_mm + c * slopes.by_c.translation_mm;
    error->rotation_rad += a * slopes.by_a.rotation_rad + c * slopes.by_c.rotation_rad;
  }
  solved.linear = tool_side_ ? linear(programmed, solved.rotary, here, stand(solved.rotary), error)
                             : linear_on_table(programmed, here, tip, solved.rotary, a, c, error);
  return solved;
}

/// As linear(), where the table carries both rotary axes and turns on from `here` by `tilt` and `turn`, rad: its point
/// and direction are turned about the joints' lines, the inner one first.
Corrector::Linear Corrector::linear_on_table(const Commanded& programmed, const Stand& here, const Vector3d& nominal,
                                             IndexedPosition rotary, double tilt, double turn,
                                             const std::optional<PoseError>& known) const {
  const double by[2] = {chain_.tilt_index() == 0 ? tilt : turn, chain_.tilt_index() == 0 ? turn : tilt};
  Vector3d tip = nominal;
  for (std::size_t i = 2; i-- > 0;) tip = here.pivots[i] + turned(Vector3d(tip - here.pivots[i]), here.lines[i], by[i]);
  Linear result;
  result.error = known ? *known : error_at(programmed, rotary, tip);
  const Vector3d deviation = rotation(result.error.rotation_rad) * tip - tip + result.error.translation_mm;
  result.deviation_mm = deviation.norm();
  result.tip_r_mm = tip + deviation;
  if (settings_.tcp == ToolCentrePoint::on) {
    Vector3d back = deviation;
    for (std::size_t i = 0; i < 2; ++i) back = turned(back, here.lines[i], -by[i]);
    result.change_mm = here.w_rotation.transpose() * back;
  } else {
    result.change_mm = deviation + (tip - nominal);
  }
  return result;
}

Angle Corrector::tilt_error(const Commanded& programmed, IndexedPosition rotary) const {
  const Stand meant = stand(programmed.rotary), there = stand(rotary);
  const Vector3d wanted_w = meant.w_rotation.transpose() * meant.t_rotation.col(2);
  const PoseError error = error_at(programmed, rotary, there.w_rotation * tip_w(programmed, meant) + there.w_origin);
  const Vector3d wanted = rotation(error.rotation_rad) * (there.w_rotation * wanted_w);
  const Vector3d tool = there.t_rotation.col(2);
  return Angle::radians(std::atan2(wanted.cross(tool).norm(), wanted.dot(tool)));
}

double Corrector::tip_error_mm(const Commanded& programmed, const Commanded& commanded) const {
  return (linear(programmed, commanded.rotary).change_mm + programmed.xyz_mm - commanded.xyz_mm).norm();
}

}  // namespace trunnion
