#pragma once

#include <compare>

namespace trunnion {

/// A length. Inside it is millimetres; micrometres belong to errors, inches to programs that say so.
class Length {
 public:
  constexpr Length() = default;
  static constexpr Length millimetres(double value) { return Length(value); }
  static constexpr Length micrometres(double value) { return Length(value * 1e-3); }
  static constexpr Length inches(double value) { return Length(value * 25.4); }

  constexpr double in_millimetres() const { return millimetres_; }
  constexpr double in_micrometres() const { return millimetres_ * 1e3; }

  friend constexpr auto operator<=>(Length, Length) = default;
  friend constexpr Length operator+(Length a, Length b) { return Length(a.millimetres_ + b.millimetres_); }
  friend constexpr Length operator-(Length a, Length b) { return Length(a.millimetres_ - b.millimetres_); }
  friend constexpr Length operator-(Length a) { return Length(-a.millimetres_); }
  friend constexpr Length operator*(double factor, Length a) { return Length(factor * a.millimetres_); }

 private:
  explicit constexpr Length(double millimetres) : millimetres_(millimetres) {}
  double millimetres_ = 0;
};

}  // namespace trunnion
