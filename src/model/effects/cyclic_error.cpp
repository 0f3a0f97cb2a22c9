#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>

#include "geometric_errors/rotary_errors.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

constexpr int kHighestOrder = 100000;
constexpr double kLeastCycles = 1.5;  // over the tilts measured: slower ones are what the map of the tilt is

/// A rotary axis stands at q + a cos(n q) + b sin(n q): n = 1, 2 encoder and bearing, n = teeth of the worm wheel or
/// lines of the encoder. Relative to the reference pose, where the workpiece was set up, as all rotary errors are:
///   e = J_here (0; u) f(q) + J_reference (0; u) f(0),   f = (cos n q, sin n q),  u the axis' direction.
Formula cyclic_error(char axis, int order, const EffectContext& context) {
  const KinematicChain& chain = *context.chain;
  const bool turning = axis == 'C';
  const Eigen::Vector3d u = chain.rotary_joints()[turning ? chain.turn_index() : chain.tilt_index()].direction;
  const Side side = chain.rotary_joints()[turning ? chain.turn_index() : chain.tilt_index()].side;
  return {
      .id = std::string("cyclic_error:") + axis + ":" + std::to_string(order),
      .moves_table = side == Side::workpiece,
      .depends_on = {std::string(1, axis) + "_deg"},
      .parameters = {{"cos", Unit::urad}, {"sin", Unit::urad}},
      .basis =
          [=, owner = context.chain](const Situation& s, const Eigen::VectorXd&) {
            const RelativeErrorJacobian j = relative_error_jacobian(*owner, s.at, {s.point_r_mm, s.tool_length_mm});
            const Eigen::Index first = turning ? 9 : 3;
            const double phase = order * (turning ? s.at.c : s.at.a).in_radians();
            const Vector6d here = j.here.middleCols<3>(first) * u;
            Matrix6Xd b(6, 2);
            b.col(0) = std::cos(phase) * here + j.reference.middleCols<3>(first) * u;
            b.col(1) = std::sin(phase) * here;
            return b;
          },
  };
}

Formula cyclic_error(const std::string& detail, const EffectContext& context) {
  int order = 0;
  const char* last = detail.data() + detail.size();
  const bool axis_known =
      detail.size() > 2 && (detail[0] == 'C' || detail[0] == context.tilt_letter) && detail[1] == ':';
  if (!axis_known || std::from_chars(detail.data() + 2, last, order).ptr != last || order < 1 || order > kHighestOrder)
    refuse_detail("cyclic_error", detail, "a rotary axis of the machine and cycles per turn, such as C:6,");
  return cyclic_error(detail[0], order, context);
}

/// The orders that the measured angles can tell apart: all low ones, and the usual teeth of worm wheels and lines of
/// encoders, each only if cos(n q), sin(n q) at the angles are not those of a lower order.
std::vector<int> distinguishable_orders(const std::vector<double>& angles) {
  std::set<int> wanted;
  for (int n = 1; n <= std::clamp(static_cast<int>(angles.size() / 2), 12, 100); ++n) wanted.insert(n);
  for (const int teeth :
       {32,  36,  40,  45,  48,  50,  54,  60,  64,  72,  80,  90,  96,  100, 108,  120,  128,  144,  150, 160,
        180, 192, 200, 216, 240, 256, 270, 300, 320, 360, 400, 480, 512, 720, 1024, 1800, 2048, 3600, 4096})
    wanted.insert(teeth);
  constexpr double kSame = 1e-6;
  std::vector<int> orders;
  std::vector<Eigen::ArrayXd> cosines, sines;
  const Eigen::Map<const Eigen::ArrayXd> q(angles.data(), static_cast<Eigen::Index>(angles.size()));
  for (const int n : wanted) {
    const Eigen::ArrayXd c = (n * q).cos(), s = (n * q).sin();
    bool known = (c - 1).abs().maxCoeff() < kSame && s.abs().maxCoeff() < kSame;
    for (std::size_t k = 0; k < orders.size() && !known; ++k)
      known = (c - cosines[k]).abs().maxCoeff() < kSame &&
              ((s - sines[k]).abs().maxCoeff() < kSame || (s + sines[k]).abs().maxCoeff() < kSame);
    if (known) continue;
    orders.push_back(n);
    cosines.push_back(c);
    sines.push_back(s);
  }
  return orders;
}

/// Angles that occur, to a millidegree; a long log is thinned.
std::vector<double> measured_angles(const CandidateScope& scope, bool turning) {
  constexpr std::size_t kEnough = 720;
  std::set<long> seen;
  const std::size_t stride = scope.readings.size() / 20000 + 1;
  for (std::size_t r = 0; r < scope.readings.size(); r += stride) {
    const IndexedPosition at = scope.readings[r].at;
    seen.insert(std::lround((turning ? at.c : at.a).in_degrees() * 1000));
  }
  std::vector<double> angles;
  std::size_t index = 0;
  for (const long millidegrees : seen)
    if (index++ % (seen.size() / kEnough + 1) == 0) angles.push_back(Angle::degrees(1e-3 * millidegrees).in_radians());
  return angles;
}

}  // namespace

Family cyclic_error_family() {
  return {
      .name = "cyclic_error",
      .what = "a rotary axis errs a whole number of times a turn: encoder, bearing, worm wheel",
      .remedy = "seven or nine unequal angles of the axis, and a fine sweep over one tooth",
      .absurd = from_unit(500, Unit::urad),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            for (const char axis : {'C', scope.context.tilt_letter}) {
              const std::vector<double> angles = measured_angles(scope, axis == 'C');
              if (angles.size() < 2) continue;
              const double span = (angles.back() - angles.front()) / (2 * std::numbers::pi);
              for (const int order : distinguishable_orders(angles))
                if (axis == 'C' || order * span > kLeastCycles)
                  found.push_back(make_effect(cyclic_error(axis, order, scope.context)));
            }
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        return make_effect(cyclic_error(detail, context), json);
      },
  };
}

}  // namespace trunnion
