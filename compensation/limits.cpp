#include "compensation/limits.h"

#include <array>
#include <cmath>

#include "error.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kApart_deg = 0.25;  // nodes are further apart

/// The output that changes most from here along a rotary axis, and by how much: mm or deg per deg.
std::pair<char, double> steepest(const CompensationTask& task, const Situation& s, const PlayedCompensation& played,
                                 char along) {
  const Angle half = Angle::degrees(kApart_deg / 2);
  Situation before = s, after = s;
  Angle &low_place = along == 'C' ? before.at.c : before.at.a, &high_place = along == 'C' ? after.at.c : after.at.a;
  low_place = low_place - half;
  high_place = high_place + half;
  const AxisCorrection low = played.at(before), high = played.at(after);
  const Eigen::Vector3d moved = high.linear_mm - low.linear_mm;
  const std::array<std::pair<char, double>, 5> changes = {
      {{'X', moved.x()},
       {'Y', moved.y()},
       {'Z', moved.z()},
       {task.machine.tilt_letter(), Angle::radians(high.tilt_rad - low.tilt_rad).in_degrees()},
       {'C', Angle::radians(high.turn_rad - low.turn_rad).in_degrees()}}};
  std::pair<char, double> most = {'X', 0};
  for (const auto& [output, change] : changes)
    if (std::abs(change) / kApart_deg > most.second) most = {output, std::abs(change) / kApart_deg};
  return most;
}

}  // namespace

ProfileNumber slope_limit() {
  return {"table_slope", "largest change of a correction on the way of a rotary axis, mm or deg per deg", 0.016, 1e-6,
          1};
}

void refuse_beyond_limits(const Controller& controller, const CompensationTask& task,
                          const std::vector<Situation>& sample, const PlayedCompensation& played) {
  const CorrectionLimits& limits = task.machine.limits;
  const auto check = [&](const Situation& s, const char* what, double found, double limit, const char* unit,
                         const char* key) {
    if (found <= limit) return;
    throw RangeError(printed("%s at %c %.3f C %.3f deg is %.4g %s, limits.%s allows %.4g", what,
                             task.machine.tilt_letter(), s.at.a.in_degrees(), s.at.c.in_degrees(), found, unit, key,
                             limit));
  };
  const double slope = task.profile.number("table_slope");
  const Model perfect;
  for (const Situation& s : sample) {
    const AxisCorrection c = played.at(s);
    // What the rotary axes move along with them is no deviation of the machine's.
    const double deviation = remaining(perfect, task.chain, s, c).position_mm.norm();
    check(s, "the deviation that the tables correct", deviation * 1e3, limits.deviation.in_micrometres(), "um",
          "correction_um");
    check(s, "the tables' turn of the tilting axis", std::abs(c.tilt_rad) * 1e6, limits.tilt.in_microradians(), "urad",
          "correction_urad");
    check(s, "the tables' turn of C", Angle::radians(std::abs(c.turn_rad)).in_degrees(),
          (limits.rotary_word + limits.tilt).in_degrees(), "deg", "correction_C_deg (and correction_urad)");
    if (!controller.by_tables) continue;
    for (const char along : {task.machine.tilt_letter(), 'C'}) {
      const auto [output, found] = steepest(task, s, played, along);
      if (found <= slope) continue;
      throw RangeError(printed(
          "the tables' %c changes by %.4g %s per deg of %c at %c %.3f C %.3f deg, profile.table_slope allows %.4g",
          output, found, output < 'X' ? "deg" : "mm", along, task.machine.tilt_letter(), s.at.a.in_degrees(),
          s.at.c.in_degrees(), slope));
    }
  }
}

}  // namespace trunnion
