#pragma once

#include <string_view>

namespace trunnion {

/// The units that parameters carry in files. Inside, lengths are mm and angles rad.
enum class Unit {
  one,
  um,
  urad,
  um_per_m,
  urad_per_m,
  um_per_m2,
  um_per_m3,
  um_per_K,
  urad_per_K,
  um_per_m_per_K,
  um_per_h,
  urad_per_h,
  um_per_m_per_h,
  urad_per_kg,
  mm,
  deg,
  s,
  K
};

/// A unit as files write it, and its value inside.
struct UnitText {
  Unit unit;
  std::string_view text;
  double inside;  ///< what one of this unit is inside (mm, rad, s, K)
};

inline constexpr UnitText kUnits[] = {
    {Unit::one, "1", 1.0},
    {Unit::um, "um", 1e-3},
    {Unit::urad, "urad", 1e-6},
    {Unit::um_per_m, "um/m", 1e-6},
    {Unit::urad_per_m, "urad/m", 1e-9},
    {Unit::um_per_m2, "um/m^2", 1e-9},
    {Unit::um_per_m3, "um/m^3", 1e-12},
    {Unit::um_per_K, "um/K", 1e-3},
    {Unit::urad_per_K, "urad/K", 1e-6},
    {Unit::um_per_m_per_K, "um/m/K", 1e-6},
    {Unit::um_per_h, "um/h", 1e-3 / 3600},
    {Unit::urad_per_h, "urad/h", 1e-6 / 3600},
    {Unit::um_per_m_per_h, "um/m/h", 1e-6 / 3600},
    {Unit::urad_per_kg, "urad/kg", 1e-6},
    {Unit::mm, "mm", 1.0},
    {Unit::deg, "deg", 0.017453292519943295},
    {Unit::s, "s", 1.0},
    {Unit::K, "K", 1.0},
};

constexpr const UnitText& unit_text(Unit unit) {
  for (const UnitText& entry : kUnits)
    if (entry.unit == unit) return entry;
  return kUnits[0];
}

/// Inside value of `value` given in `unit`, and back.
constexpr double from_unit(double value, Unit unit) { return value * unit_text(unit).inside; }
constexpr double to_unit(double inside, Unit unit) { return inside / unit_text(unit).inside; }

}  // namespace trunnion
