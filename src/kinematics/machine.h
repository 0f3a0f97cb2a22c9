#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "kinematics/structure.h"
#include "units/angle.h"
#include "units/length.h"

namespace trunnion {

/// From `low` to `high`, both within.
template <class Quantity>
struct Range {
  Quantity low;
  Quantity high;
  friend bool operator==(const Range&, const Range&) = default;
};

/// One axis as the machine file tells it. A rotary axis turns what it carries right-handed about `direction` as its
/// command grows; `origin_mm` is a point of its line in R at A = C = 0. On the tool side the origin is told from the
/// tool's reference point (the spindle nose), with all axes at zero.
struct Axis {
  char letter = '?';
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit vector in R
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
  std::optional<Range<Angle>> range_angle;    ///< stroke of a rotary axis
  std::optional<Range<Length>> range_length;  ///< stroke of a linear axis
  bool modulo = false;                        ///< 0 and 360 deg are the same place

  bool rotary() const { return letter == 'A' || letter == 'B' || letter == 'C'; }
};

/// The touch-trigger probe of a machine file.
struct Probe {
  Length sigma = Length::micrometres(0.175);  ///< 1-sigma of one touch
  Length ball_radius = Length::millimetres(3);
};

/// What protects the machine while correcting (CONTRACT: [limits]).
struct CorrectionLimits {
  Length deviation = Length::micrometres(200);  ///< largest |d| that is corrected
  Angle tilt = Angle::microradians(1000);       ///< largest tilt that is corrected
  Angle rotary_word = Angle::degrees(0.1);      ///< largest change of a word near the singularity
};

/// The volume that tables and reports speak of; what is not told has its default in work_volume().
struct WorkVolume {
  std::optional<Range<Angle>> a;
  std::optional<Range<Angle>> c;
  std::optional<Range<Length>> x, y, z;
};

/// An entry of a controller's profile: text, number or switch, as the machine file says it.
using ProfileValue = std::variant<std::string, double, bool>;

/// A five-axis machine as its file describes it.
struct Machine {
  std::string name;
  std::string serial;
  Structure structure;
  std::string controller;     ///< empty where the file does not say
  std::map<char, Axis> axes;  ///< all five, those the file left out with their defaults
  Probe probe;
  std::string tcp = "on";  ///< what --tcp auto means in a dialect whose programs do not say
  CorrectionLimits limits;
  WorkVolume work_volume;
  std::map<std::string, ProfileValue> profile;  ///< facts about its control that were confirmed on it

  char tilt_letter() const { return axes.contains('A') ? 'A' : 'B'; }
  const Axis& tilt() const { return axes.at(tilt_letter()); }
  const Axis& turn() const { return axes.at('C'); }
};

/// The five axes of `structure` with their usual directions, origins at R's zero and no strokes.
std::map<char, Axis> default_axes(const Structure& structure);

}  // namespace trunnion
