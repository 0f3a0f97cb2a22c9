#include <algorithm>
#include <cmath>
#include <map>

#include "compensation/controllers/fanuc_files.h"
#include "compensation/grid_table.h"
#include "compensation/number_text.h"
#include "error.h"
#include "units/angle.h"

// What a FANUC does with the files that it was given: written from its manuals, not from the emitter.

namespace trunnion::fanuc {
namespace {

/// The pitch errors of one axis, as the control holds them.
struct Pitch {
  long reference = 0, lowest = 0, highest = 0, lowest_down = -1;
  double interval_deg = 1, magnification = 1, turn_deg = 0, at_reference_down = 0;
  bool has_reference_down = false;
  std::vector<double> totals, totals_down;  ///< added up from the most negative point on, in units of 3623
};

class Fanuc : public PlayedCompensation {
 public:
  Fanuc(const std::vector<Entry>& entries, const CompensationTask& task, const std::string& file)
      : nominal_(task.chain),
        unit_(detection_unit_deg(task)),
        adds_(task.profile.answer("pitch_sign") != "subtract"),
        reference_in_detection_units_(task.profile.answer("pitch_reference") == "in detection units") {
    Machine moved = task.machine;
    const Eigen::Vector3d nominal_tilt = moved.tilt().origin_mm;
    Eigen::Vector3d tilt = nominal_tilt, turn = moved.turn().origin_mm - nominal_tilt;
    const std::map<char, long> numbers = axis_numbers(task);
    const std::map<long, Pitch*> by_axis = {{numbers.at(moved.tilt_letter()), &tilt_}, {numbers.at('C'), &turn_}};
    std::map<long, double> points;
    for (const Entry& e : entries) {
      if (e.number >= kPitchBase && e.number < 19000) points[e.number - kPitchBase] = e.value;
      if (e.number >= 19700 && e.number <= 19702) tilt[e.number - 19700] = e.value;
      if (e.number >= 19703 && e.number <= 19705) turn[e.number - 19703] = e.value;
      if (e.number == 19680 && e.value != 12)
        throw InputError(file, "19680 is " + shortest_text(e.value) + ", 12 (two table axes) is wanted");
      if (e.number < 3600 || e.number > 3630) continue;
      const auto found = by_axis.find(e.axis);
      if (found == by_axis.end())
        throw InputError(file, "N" + std::to_string(e.number) + ": axis " + std::to_string(e.axis) +
                                   " is not a rotary axis of this machine");
      set(*found->second, e);
    }
    for (Pitch* pitch : {&tilt_, &turn_}) add_up(*pitch, points, file);
    moved.axes.at(moved.tilt_letter()).origin_mm = tilt;
    moved.axes.at('C').origin_mm = tilt + turn;
    believed_ = KinematicChain(moved);
  }

  AxisCorrection at(const Situation& s) const override {
    // With tool centre point control the linear axes go where the control believes the point to be.
    const Eigen::Vector3d w = nominal_.r_from_w(s.at).inverse() * s.point_r_mm;
    return {believed_.r_from_w(s.at) * w - s.point_r_mm, correction(tilt_, s.at.a.in_degrees(), s.tilt_sense),
            correction(turn_, s.at.c.in_degrees(), s.turn_sense)};
  }

 private:
  static void set(Pitch& pitch, const Entry& e) {
    const long whole = std::lround(std::clamp(e.value, -1e6, 1e6));
    if (e.number == 3620) pitch.reference = whole;
    if (e.number == 3621) pitch.lowest = whole;
    if (e.number == 3622) pitch.highest = whole;
    if (e.number == 3623) pitch.magnification = e.value;
    if (e.number == 3624) pitch.interval_deg = e.value;
    if (e.number == 3625) pitch.turn_deg = e.value;
    if (e.number == 3626) pitch.lowest_down = whole;
    if (e.number == 3627) pitch.at_reference_down = e.value, pitch.has_reference_down = true;
  }

  static void add_up(Pitch& pitch, const std::map<long, double>& points, const std::string& file) {
    if (!(pitch.interval_deg > 0) || pitch.lowest < 0 || pitch.highest <= pitch.lowest ||
        pitch.highest - pitch.lowest > 10000 || pitch.reference < pitch.lowest || pitch.reference > pitch.highest)
      throw InputError(file, "3620 to 3624: points from low to high about the reference, and an interval, are wanted");
    const bool turns = pitch.turn_deg > 0;
    if (turns &&
        (pitch.lowest != pitch.reference ||
         std::abs(static_cast<double>(pitch.highest - pitch.lowest) * pitch.interval_deg - pitch.turn_deg) > 1e-3))
      throw InputError(file,
                       "3621 " + std::to_string(pitch.lowest) + ", 3622 " + std::to_string(pitch.highest) +
                           ": a rotary axis has its points from the reference (3620) on for a turn (3625) in steps "
                           "of 3624");
    if (pitch.has_reference_down != (pitch.lowest_down >= 0))
      throw InputError(file, "3626 and 3627: both or neither are wanted");
    const auto totals = [&](long lowest) {
      std::vector<double> sums;
      double total = 0;
      for (long n = lowest; n <= lowest + pitch.highest - pitch.lowest; ++n) {
        const auto found = points.find(n);
        if (found == points.end()) throw InputError(file, "pitch point " + std::to_string(n) + " is missing");
        if (n > lowest) total += found->second;
        sums.push_back(total);
      }
      if (turns && std::abs(total) > 1e-6)
        throw InputError(file,
                         "increments of a rotary axis add up to " + shortest_text(total) + " in a turn, 0 is wanted");
      const long last = lowest + pitch.highest - pitch.lowest;
      if (turns && std::abs(points.at(lowest) - points.at(last)) > 1e-6)
        throw InputError(file, "points " + std::to_string(lowest) + " and " + std::to_string(last) +
                                   " of a rotary axis are the same place and differ");
      return sums;
    };
    pitch.totals = totals(pitch.lowest);
    if (pitch.has_reference_down) pitch.totals_down = totals(pitch.lowest_down);
  }

  /// The increments passed on the way from the reference, the change spread evenly between points. Those for negative
  /// travel are counted upwards as well, and begin at the reference from what stands there.
  double correction(const Pitch& pitch, double degrees, int sense) const {
    if (pitch.turn_deg > 0) degrees -= pitch.turn_deg * std::floor(degrees / pitch.turn_deg);
    const bool down = sense < 0 && pitch.has_reference_down;
    const std::vector<double>& totals = down ? pitch.totals_down : pitch.totals;
    std::vector<double> nodes;
    for (long n = pitch.lowest; n <= pitch.highest; ++n)
      nodes.push_back(static_cast<double>(n - pitch.reference) * pitch.interval_deg);
    const double passed = interpolated(nodes, totals, Boundary::hold, degrees) -
                          totals[static_cast<std::size_t>(pitch.reference - pitch.lowest)];
    const double units =
        passed * pitch.magnification +
        (down ? pitch.at_reference_down * (reference_in_detection_units_ ? 1 : pitch.magnification) : 0);
    return (adds_ ? 1 : -1) * units * unit_ * kDegree_rad;
  }

  KinematicChain nominal_, believed_{nominal_};
  double unit_;
  bool adds_, reference_in_detection_units_;
  Pitch tilt_, turn_;
};

}  // namespace

std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task) {
  const auto named = [&](const char* name) { return std::ranges::find(files, name, &TableFile::name); };
  const auto file = named(kParameterFile) != files.end() ? named(kParameterFile) : named(kUnroundedFile);
  if (file == files.end()) throw InputError(kParameterFile, "missing");
  const std::vector<Entry> entries = read_parameters(*file);
  if (const auto program = named(kProgramFile); program != files.end()) {
    const std::vector<Entry> same = read_program(*program);
    for (std::size_t k = 0; k < std::max(same.size(), entries.size()); ++k)
      if (k >= same.size() || k >= entries.size() || same[k].number != entries[k].number ||
          same[k].axis != entries[k].axis || same[k].value != entries[k].value)
        throw InputError(program->name, 4 + k, "not what " + file->name + ":" + std::to_string(2 + k) + " says");
  }
  return std::make_unique<Fanuc>(entries, task, file->name);
}

}  // namespace trunnion::fanuc
