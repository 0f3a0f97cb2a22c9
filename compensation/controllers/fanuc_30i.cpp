#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "compensation/controllers/controllers.h"
#include "compensation/controllers/fanuc_files.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"
#include "model/effects/location_errors.h"
#include "units/angle.h"

// FANUC 30i: stored pitch errors of A and C, as increments from point to point, and the places of the two table axes in
// the parameters of tool centre point control.

namespace trunnion {
namespace fanuc_30i_set {
namespace {

using fanuc::Entry;

constexpr long kMostPoints = 128;  // of one axis, one way
/// Pitch points: the reference position of each axis, and the most negative point for negative travel.
struct PointNumbers {
  long reference, lowest_down;
};
constexpr PointNumbers kTiltPoints = {60, 250}, kTurnPoints = {500, 700};

/// One axis' corrections at its nodes, and how far it stands off after negative travel; degrees.
struct Corrections {
  char axis;
  bool turning;
  double interval_deg;
  std::vector<double> nodes_deg, values_deg;
  double reversal_deg;
};

/// To the nearest whole number, halves towards zero: at the reference nothing is passed.
double whole(double counts) { return std::copysign(std::max(0.0, std::ceil(std::abs(counts) - 0.5 - 1e-9)), counts); }

/// What stands to be added at the points of one way of travel, in detection units, and of it what the control counts
/// from at the reference.
struct Way {
  std::vector<double> wanted;
  double at_reference = 0;

  /// Totals of whole increments: each within half of what 3623 makes of one, whatever was rounded before it.
  std::vector<double> counted(double magnification, bool rounded) const {
    std::vector<double> totals;
    for (const double value : wanted) {
      const double counts = (value - at_reference) / magnification;
      totals.push_back(rounded ? whole(counts) : counts);
    }
    return totals;
  }
};

/// The smallest of 3623 with which no increment of either way is larger than 7.
double magnification_of(const std::function<std::vector<Way>(double)>& ways) {
  for (double magnification = 1;; ++magnification) {
    double largest = 0;
    for (const Way& way : ways(magnification)) {
      const std::vector<double> totals = way.counted(magnification, true);
      for (std::size_t k = 1; k < totals.size(); ++k) largest = std::max(largest, std::abs(totals[k] - totals[k - 1]));
    }
    if (largest <= 7) return magnification;
    if (largest > 14) magnification = std::max(magnification, std::floor(magnification * (largest - 1) / 7) - 1);
  }
}

/// One axis' parameters and its increments from point to point.
void append_pitch(const CompensationTask& task, std::vector<Entry>& entries, const Corrections& c, Emission emission) {
  const double in_units = (task.profile.answer("pitch_sign") == "add" ? 1 : -1) / fanuc::detection_unit_deg(task);
  const double off = -in_units * c.reversal_deg;
  // Negative travel has points of its own, the same pitch from another beginning.
  const bool both_ways = std::abs(c.reversal_deg) > 1e-9;
  const bool counts_reference = task.profile.answer("pitch_reference") == "in detection units";
  const auto ways = [&](double magnification, bool rounded) {
    std::vector<Way> list(both_ways ? 2 : 1);
    const double unit = counts_reference ? 1 : magnification;
    if (both_ways) list[1].at_reference = rounded ? unit * whole(off / unit) : off;
    for (const double value : c.values_deg)
      for (Way& way : list) way.wanted.push_back(in_units * value + (&way == &list[0] ? 0 : off));
    return list;
  };
  const double magnification = magnification_of([&](double tried) { return ways(tried, true); });
  if (emission.for_the_control() && magnification > 100)
    throw RangeError("fanuc-30i: pitch errors ask for a magnification (3623) of " + shortest_text(magnification) +
                     ", 100 is the most");
  const auto first = std::lround(c.nodes_deg.front() / c.interval_deg),
             last = std::lround(c.nodes_deg.back() / c.interval_deg);
  if (emission.for_the_control() && last - first + 1 > kMostPoints)
    throw RangeError("fanuc-30i: " + std::to_string(last - first + 1) + " points on one axis, 128 is the most");
  const PointNumbers numbers = c.turning ? kTurnPoints : kTiltPoints;
  const long reference = std::max(numbers.reference, -first), axis = axis_numbers(task).at(c.axis);
  const auto add = [&](long number, double value, bool real = false) {
    entries.push_back({number, axis, value, real});
  };
  add(3620, static_cast<double>(reference));
  add(3621, static_cast<double>(reference + first));
  add(3622, static_cast<double>(reference + last));
  add(3623, magnification);
  add(3624, c.interval_deg, true);
  if (c.turning) add(3625, 360, true);
  const std::vector<Way> of_both = ways(magnification, emission.quantised);
  if (both_ways) {
    add(3626, static_cast<double>(numbers.lowest_down));
    add(3627, of_both[1].at_reference / (counts_reference ? 1 : magnification));
  }
  for (const Way& way : of_both) {
    const std::vector<double> totals = way.counted(magnification, emission.quantised);
    const long lowest = &way == &of_both[0] ? reference + first : numbers.lowest_down;
    for (std::size_t k = 0; k < totals.size(); ++k) {
      // The first point of a turn is the last one again; the most negative point of a stroke has nothing before it.
      const double increment = k > 0       ? totals[k] - totals[k - 1]
                               : c.turning ? totals.back() - totals[totals.size() - 2]
                                           : 0;
      entries.push_back({fanuc::kPitchBase + lowest + static_cast<long>(k), 0, increment});
    }
  }
}

/// Whether there is a node at the reference position, where the control's corrections begin from zero.
bool has_zero(const std::vector<double>& nodes) {
  return std::ranges::any_of(nodes, [](double node) { return std::abs(node) < 1e-9; });
}

/// Steps of at most `step_deg` that make a turn and are told by the decimals of 3624.
double turn_interval(double step_deg) {
  double cells = std::ceil(360 / step_deg - 1e-9);
  while (std::abs(rounded(360 / cells, 4) * cells - 360) > 1e-9) ++cells;
  return 360 / cells;
}

/// Where the control believes the axes to stand.
struct Places {
  Eigen::Vector3d tilt, turn_from_tilt;
};
Places nominal_places(const CompensationTask& task) {
  const Eigen::Vector3d tilt = task.machine.tilt().origin_mm;
  return {tilt, task.machine.turn().origin_mm - tilt};
}

std::vector<TableFile> emit(const CompensationTask& task, Angle spacing, Emission emission) {
  if (task.chain.has_rotary(Side::tool) || task.chain.turn_carries_tilt())
    throw RefusalError("fanuc-30i: structure \"" + task.machine.structure.code +
                       "\": a table with C carried by the tilting axis is wanted (19680 = 12)");
  const double interval = spacing.in_degrees() / emission.refine;
  const double low = std::floor(task.volume.a.low.in_degrees() / interval + 1e-9),
               high = std::ceil(task.volume.a.high.in_degrees() / interval - 1e-9);
  const double turn_step = emission.for_the_control() ? turn_interval(interval) : interval;
  std::vector<double> tilt_nodes, turn_nodes = even_nodes(0, 360, turn_step);
  for (double k = low; k <= std::max(high, low + 1); ++k) tilt_nodes.push_back(k * interval);
  if (!has_zero(tilt_nodes))
    throw RefusalError(
        "fanuc-30i: the working volume does not reach the reference position of the tilting axis, from which pitch "
        "errors are counted");
  const PiecewiseLinear tilt(tilt_nodes, Boundary::hold), turn(turn_nodes, Boundary::repeat);
  // Points outside what was probed are not asked for: the model holds at its end.
  std::vector<double> tilt_at =
      even_nodes(task.volume.a.low.in_degrees(), task.volume.a.high.in_degrees(), interval / 4);
  const std::vector<double> turn_at = turn.sample_points(3);
  EffectContext context = effect_context(task.machine);
  const EffectPtr location = make_location_errors(context);
  const OwnAxisFit fit = own_axis_fit(task, volume_metric(task.volume), tilt_at, turn_at, location);
  const auto values = [](const Eigen::MatrixXd& projector, const std::vector<double>& sampled) {
    const Eigen::VectorXd v =
        projector * Eigen::Map<const Eigen::VectorXd>(sampled.data(), static_cast<Eigen::Index>(sampled.size())) /
        kDegree_rad;
    return std::vector<double>(v.begin(), v.end());
  };
  std::vector<double> held_tilt = fit.tilt_rad;
  while (tilt_at.front() > tilt_nodes.front() + 1e-9) {
    tilt_at.insert(tilt_at.begin(), std::max(tilt_nodes.front(), tilt_at.front() - interval / 4));
    held_tilt.insert(held_tilt.begin(), held_tilt.front());
  }
  while (tilt_at.back() < tilt_nodes.back() - 1e-9) {
    tilt_at.push_back(std::min(tilt_nodes.back(), tilt_at.back() + interval / 4));
    held_tilt.push_back(held_tilt.back());
  }
  const double tilt_reversal = reversal_rad(task, task.machine.tilt_letter()) / kDegree_rad,
               turn_reversal = reversal_rad(task, 'C') / kDegree_rad;

  std::vector<Entry> entries;
  append_pitch(task, entries,
               {task.machine.tilt_letter(), false, interval, tilt_nodes, values(tilt.projector(tilt_at, 0), held_tilt),
                tilt_reversal},
               emission);
  append_pitch(task, entries,
               {'C', true, turn_nodes[1], turn_nodes, values(turn.projector(turn_at, 0), fit.turn_rad), turn_reversal},
               emission);
  // The axes' places: nominal ones moved by the location errors that are lengths.
  Places places = nominal_places(task);
  for (std::size_t k = 0; k < location->parameters().size(); ++k) {
    const Parameter& parameter = location->parameters()[k];
    if (parameter.unit != Unit::um) continue;
    const Eigen::Index along = parameter.name[1] - 'X';
    (parameter.name[3] == 'C' ? places.turn_from_tilt : places.tilt)[along] +=
        fit.constants[static_cast<Eigen::Index>(k)];
  }
  entries.push_back({19680, 0, 12});
  for (Eigen::Index k = 0; k < 3; ++k) entries.push_back({19700 + k, 0, places.tilt[k], true});
  for (Eigen::Index k = 0; k < 3; ++k) entries.push_back({19703 + k, 0, places.turn_from_tilt[k], true});

  std::vector<TableFile> files = {fanuc::parameter_file(entries, emission)};
  if (emission.for_the_control())
    files.push_back(fanuc::program_file(
        entries, (task.profile.load_ready() ? "" : std::string(kNotLoadReady) + ". ") + provenance(task)));
  return files;
}

std::string loading(const CompensationTask& task, const std::vector<TableFile>& files) {
  const bool reverses =
      std::ranges::any_of(files, [](const TableFile& f) { return f.text.find("\nN3627") != std::string::npos; });
  return "## Steps\n\n1. Save all parameters and pitch error data of the machine first.\n2. Parameter write enable; "
         "read in `" +
         std::string(fanuc::kParameterFile) + "` (or run `" + fanuc::kProgramFile +
         "`, which says the same).\n3. Power off and on (3620 to 3627), then return to the reference position.\n4. "
         "Tool centre point control: 19700 to 19705 hold where the axes "
         "were found, counted from R's origin as the machine file has it. Add your machine's own origin if it "
         "differs.\n" +
         (reverses
              ? "5. Bit 0 of 3605 = 1 for the axes that have a 3626 and a 3627: negative travel has points of its own. "
                "The file leaves 3605 alone, its other bits are the machine's.\n"
              : "") +
         "\nThe detection unit is taken as " + shortest_text(fanuc::detection_unit_deg(task)) +
         " deg (profile.detection_unit_deg). The numbers of 3623 and 3624 belong to it.\n\nUndo: read the saved data "
         "back in; power off and on.\n";
}

/// A pitch of seven units up and down again, 30 deg apart, on the way of each rotary axis from its reference.
std::vector<TableFile> commissioning(const CompensationTask& task) {
  std::string text = "%\n";
  for (const bool turning : {false, true}) {
    const long reference = (turning ? kTurnPoints : kTiltPoints).reference, low = turning ? 0 : -3,
               high = turning ? 12 : 3;
    const std::string axis =
        "A" +
        shortest_text(task.profile.number(std::string("axis_number_") + (turning ? 'C' : task.machine.tilt_letter())));
    const auto line = [&](long number, const std::string& value) {
      text += "N" + std::to_string(number) + (number < fanuc::kPitchBase ? axis : "") + "P" + value + ";\n";
    };
    line(3620, std::to_string(reference));
    line(3621, std::to_string(reference + low));
    line(3622, std::to_string(reference + high));
    line(3623, "1");
    line(3624, "30.0000");
    if (turning) line(3625, "360.0000");
    for (long k = low; k <= high; ++k)
      line(fanuc::kPitchBase + reference + k, k == -1 || (turning && k == 2)   ? "7"
                                              : k == -2 || (turning && k == 3) ? "-7"
                                                                               : "0");
  }
  return {{"one_pitch_PARAM.TXT", text + "%\n"}};
}

}  // namespace
}  // namespace fanuc_30i_set

Controller fanuc_30i() {
  using namespace fanuc_30i_set;
  std::vector<ProfileNumber> numbers = {
      {"detection_unit_deg", "detection unit of the rotary axes", 0.0001, 1e-6, 0.01}};
  double number = 1;
  for (const char* axis : {"X", "Y", "Z", "A", "B", "C"}) {
    numbers.push_back({std::string("axis_number_") + axis, "controlled-axis number", number, 1, 32, 1});
    if (axis[0] != 'A') ++number;
  }
  return {
      .name = "fanuc-30i",
      .title = "FANUC 30i: pitch errors of A and C, places of the table axes",
      .cannot_hold =
          "everything but the positions of A and C themselves and the places of the two axes: no tilts, no radial and "
          "axial errors, no lever arms.",
      .questions =
          {{{"pitch_sign",
             "Is a stored pitch increment added to the movement, or taken from it?",
             {"add", "subtract"},
             "Load `commissioning/one_pitch_PARAM.TXT` (3620 to 3624 of {A} and C, everything else 0), power off and "
             "on, "
             "reference, turn C from 0 to 60 deg and read it against an indicator: it stands 7 detection units further "
             "than without the table if increments are added, and back in place at 90."},
            {"pitch_interpolation",
             "Is the correction spread evenly between points (interpolated type)?",
             {"even"},
             "Move slowly from one point to the next and watch the compensation on the diagnosis screen."},
            {"pitch_blocks",
             "Does the control take pitch data as N10000 + point, in a parameter file and behind G10 L52?",
             {"N10000 + point"},
             "Punch out the pitch data of the machine and compare. For the program: run a copy of it with one point "
             "only "
             "and look at the pitch error screen."},
            {"tcp_vectors",
             "Do 19700-19702 lead to the first table axis and 19703-19705 from there to the second?",
             {"yes"},
             "Compare the machine's values with its drawing; raise 19701 by 0.02 and lower 19704 by 0.02: with G43.4 "
             "at {A} -90 C 0 the linear axes stand by 0.02 elsewhere (for A: Y +0.02, Z +0.02), at {A} 0 as before."},
            {"pitch_reverse",
             "Are the increments for negative travel (points from 3626 on) counted upwards like those for positive "
             "travel, and 3627 where the reference return goes in positive direction?",
             {"upwards"},
             "Copy the points of C in `commissioning/one_pitch_PARAM.TXT` to 3626 and on, 3605#0 = 1, 3627 = 0, power "
             "off and on, reference: C stands at 60 deg alike from both sides.",
             true},
            {"pitch_reference",
             "Is 3627 counted in detection units, or in detection units times 3623?",
             {"in units of 3623", "in detection units"},
             "With 3605#0 = 1, 3623 = 2, 3627 = 10 and all points 0: coming back to the reference from above, C stands "
             "off by 20 detection units (units of 3623), or by 10.",
             true}},
           numbers},
      .spacings = {Angle::degrees(30), Angle::degrees(15), Angle::degrees(10), Angle::degrees(5), Angle::degrees(3)},
      .emit = emit,
      .play = fanuc::play,
      .loading = loading,
      .no_comments = {".TXT"},
      .commissioning = commissioning};
}

}  // namespace trunnion
