#include "postproc/plain_player.h"

#include <cmath>

namespace trunnion {

using Eigen::Vector3d;

bool PlayedMove::begins_known() const {
  for (const double place : from)
    if (std::isnan(place)) return false;
  return true;
}

double PlayedMove::way() const {
  const Vector3d straight(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
  if (arc) return std::hypot(sweep_rad * along.norm(), straight.dot(along.cross(across).normalized()));
  if (straight.norm() > 0) return straight.norm();
  return std::hypot(to[kTilt] - from[kTilt], to[kTurn] - from[kTurn]);
}

/// The angles of `place`, in proportion so far, where the tool axis turns about the normal of both directions.
void PlayedMove::turn_in_one_plane(AxisValues& place, double s, const KinematicChain& chain) const {
  const auto axis_at = [&](const AxisValues& at) {
    const IndexedPosition there{Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])};
    return Vector3d(chain.r_from_w(there).linear().transpose() * chain.r_from_t(there).linear().col(2));
  };
  const Vector3d begin = axis_at(from), normal = begin.cross(axis_at(to));
  if (normal.norm() < 1e-9) return;
  const double whole = std::atan2(normal.norm(), begin.dot(axis_at(to)));
  const Vector3d axis = Eigen::AngleAxisd(s * whole, normal.normalized()) * begin;
  ScanSettings only_chain;
  only_chain.chain = &chain;
  const auto [tilt, turn] = descended_to_axis(only_chain, axis, place[kTilt], place[kTurn]);
  place[kTilt] = tilt;
  place[kTurn] = turn;
}

AxisValues PlayedMove::at(double s, const KinematicChain* chain) const {
  AxisValues place = to;
  Vector3d xyz(to[0], to[1], to[2]);
  if (s < 1) {
    for (std::size_t i = 0; i < kAxes; ++i) place[i] = from[i] + s * (to[i] - from[i]);
    const Vector3d begin(from[0], from[1], from[2]);
    xyz = begin + s * (xyz - begin);
    if (great_circle) turn_in_one_plane(place, s, *chain);
    if (arc) {
      const Vector3d normal = along.cross(across).normalized();
      const double angle = s * sweep_rad;
      const Vector3d rise = normal * normal.dot(xyz - begin);
      Vector3d arm = Vector3d(to[0], to[1], to[2]) - centre;
      arm -= normal * normal.dot(arm);
      // A radius that the ends tell differently grows on the way.
      const double grown = 1 + s * (arm.norm() / along.norm() - 1);
      xyz = centre + grown * (std::cos(angle) * along + std::sin(angle) * across) + rise;
    } else if (straight_on_part) {
      const auto w_from_r = [&](const AxisValues& a) {
        return chain->r_from_w({Angle::degrees(a[kTilt]), Angle::degrees(a[kTurn])}).inverse();
      };
      const Vector3d on_begin = w_from_r(from) * begin, on_end = w_from_r(to) * Vector3d(to[0], to[1], to[2]);
      xyz = w_from_r(place).inverse() * Vector3d(on_begin + s * (on_end - on_begin));
    }
  }
  xyz = frame_origin_mm + frame * xyz;
  for (std::size_t i = 0; i < 3; ++i) place[i] = xyz[static_cast<Eigen::Index>(i)];
  return place;
}

std::array<double, 2> descended_to_axis(const ScanSettings& settings, const Vector3d& axis_w, double tilt_deg,
                                        double turn_deg) {
  const auto axis_at = [&](double tilt, double turn) {
    const IndexedPosition at{Angle::degrees(tilt), Angle::degrees(turn)};
    return Vector3d(settings.chain->r_from_w(at).linear().transpose() * settings.chain->r_from_t(at).linear().col(2));
  };
  constexpr double step = 1e-4;
  const double near = std::isnan(turn_deg) ? 0 : turn_deg;
  std::array<double, 2> best = {std::nan(""), std::nan("")};
  double least = 1e300;
  // Down to the axis from a start; counts the ways found, of which there are two but where the tool stands upright.
  const auto descend = [&](double tilt, double turn) {
    for (int k = 0; k < 40; ++k) {
      const Vector3d miss = axis_at(tilt, turn) - axis_w;
      if (miss.norm() < 1e-14) break;
      const Vector3d by_tilt = (axis_at(tilt + step, turn) - axis_at(tilt - step, turn)) / (2 * step);
      const Vector3d by_turn = (axis_at(tilt, turn + step) - axis_at(tilt, turn - step)) / (2 * step);
      const double aa = by_tilt.dot(by_tilt), ac = by_tilt.dot(by_turn), cc = by_turn.dot(by_turn) + 1e-16;
      const double det = aa * cc - ac * ac, ga = by_tilt.dot(miss), gc = by_turn.dot(miss);
      if (!(std::abs(det) > 1e-30)) break;
      const double to_tilt = (cc * ga - ac * gc) / det, to_turn = (aa * gc - ac * ga) / det;
      tilt -= std::remainder(to_tilt, 90);
      turn -= std::remainder(to_turn, 90);
      if (std::abs(to_tilt) + std::abs(to_turn) < 1e-10) break;
    }
    if (!((axis_at(tilt, turn) - axis_w).norm() < 1e-9)) return false;
    tilt = std::remainder(tilt, 360);
    turn += 360 * std::round((near - turn) / 360);
    const auto& stroke = settings.tilt_stroke_deg;
    if (stroke && (tilt < stroke->first - 1e-3 || tilt > stroke->second + 1e-3)) return true;
    const double away = std::abs(turn - near) + (std::isnan(tilt_deg) ? 0 : std::abs(tilt - tilt_deg));
    if (away < least - 1e-6) {
      least = away;
      best = {tilt, turn};
    }
    return true;
  };
  if (!std::isnan(tilt_deg) && !std::isnan(turn_deg) && std::abs(tilt_deg) <= 90 && descend(tilt_deg, turn_deg) &&
      descend(-best[0], best[1] + 180) && !std::isnan(best[0]))
    return best;
  for (int i = 0; i < 24; ++i) descend((i % 2 == 0 ? -1 : 1) * (5.0 + 25 * (i / 2 % 4)), near + 120.0 * (i / 8));
  return best;
}

int code_number(double value) { return value >= 0 && value < 1e6 ? static_cast<int>(value) : -1; }

std::unique_ptr<PlainPlayer> plain_player(const std::string& dialect, const ScanSettings& settings) {
  return dialect == "heidenhain" ? plain_klartext_player(settings) : plain_iso_player(dialect, settings);
}

}  // namespace trunnion
