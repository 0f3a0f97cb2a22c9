#pragma once

#include <compare>
#include <numbers>

namespace trunnion {

/// A plane angle. Inside it is radians; degrees belong to commanded positions, microradians to errors.
class Angle {
 public:
  constexpr Angle() = default;
  static constexpr Angle radians(double value) { return Angle(value); }
  static constexpr Angle degrees(double value) { return Angle(value * (std::numbers::pi / 180)); }
  static constexpr Angle microradians(double value) { return Angle(value * 1e-6); }

  constexpr double in_radians() const { return radians_; }
  constexpr double in_degrees() const { return radians_ * (180 / std::numbers::pi); }
  constexpr double in_microradians() const { return radians_ * 1e6; }

  friend constexpr auto operator<=>(Angle, Angle) = default;
  friend constexpr Angle operator+(Angle a, Angle b) { return Angle(a.radians_ + b.radians_); }
  friend constexpr Angle operator-(Angle a, Angle b) { return Angle(a.radians_ - b.radians_); }
  friend constexpr Angle operator-(Angle a) { return Angle(-a.radians_); }
  friend constexpr Angle operator*(double factor, Angle a) { return Angle(factor * a.radians_); }

 private:
  explicit constexpr Angle(double radians) : radians_(radians) {}
  double radians_ = 0;
};

inline constexpr double kTurn_rad = 2 * std::numbers::pi;
inline constexpr double kDegree_rad = std::numbers::pi / 180;
inline constexpr Angle kFullTurn = Angle::radians(kTurn_rad);

}  // namespace trunnion
