#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "compensation/controllers/controllers.h"
#include "compensation/grid_table.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"
#include "model/effects/location_errors.h"
#include "units/angle.h"

// FANUC 30i: stored pitch errors of A and C, as increments from point to point, and the places of the two table axes in
// the parameters of tool centre point control.

namespace trunnion {
namespace {

constexpr int kPlaceDecimals = 4;
constexpr const char* kParameterFile = "PARAM.TXT";
constexpr const char* kG10File = "G10.NC";
constexpr long kPitchBase = 10000;
constexpr long kReference[2] = {60, 500};  ///< points of A and of C at the reference position

/// One parameter: number, axis (0: none), value.
struct Entry {
  long number = 0, axis = 0;
  double value = 0;
  bool real = false;
};

/// The pitch errors of one axis, as the control holds them.
struct Pitch {
  long reference = 0, lowest = 0, highest = 0;
  double interval_deg = 1, magnification = 1, turn_deg = 0, reversed = 0;
  std::map<long, double> increments;
};

double total_unit(const CompensationTask& task) { return task.profile.number("detection_unit_deg"); }

/// Totals at points, in units times magnification, to increments that never add up rounding.
void append_pitch(const CompensationTask& task, std::vector<Entry>& entries, bool turning, double interval,
                  const std::vector<double>& nodes, const std::vector<double>& corrections_deg, double reversal_deg,
                  Emission emission) {
  const double sign = task.profile.answer("pitch_sign") == "add" ? 1 : -1;
  const long axis =
      std::lround(task.profile.number(std::string("axis_number_") + (turning ? 'C' : task.machine.tilt_letter())));
  const long reference = kReference[turning ? 1 : 0];
  const double unit = total_unit(task);
  std::vector<double> totals;
  double steepest = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    totals.push_back(sign * corrections_deg[k] / unit);
    if (k > 0) steepest = std::max(steepest, std::abs(totals[k] - totals[k - 1]));
  }
  const double magnification = std::max(1.0, std::ceil((steepest + 1) / 7 - 1e-9));
  if (emission.for_the_control() && magnification > 100)
    throw RangeError("fanuc-30i: pitch errors change by " + shortest_text(std::round(steepest)) +
                     " detection units a point, 700 is the most that 3623 allows");
  const auto in_units = [&](double value) {
    return emission.quantised ? std::round(value / magnification) : value / magnification;
  };
  const auto first = static_cast<long>(std::lround(nodes.front() / interval));
  const auto last = static_cast<long>(std::lround(nodes.back() / interval));
  if (emission.for_the_control() && last - first + 1 > 128)
    throw RangeError("fanuc-30i: " + std::to_string(last - first + 1) + " points on one axis, 128 is the most");
  entries.push_back({3620, axis, static_cast<double>(reference)});
  entries.push_back({3621, axis, static_cast<double>(reference + first)});
  entries.push_back({3622, axis, static_cast<double>(reference + last)});
  entries.push_back({3623, axis, magnification});
  entries.push_back({3624, axis, interval, true});
  if (turning) entries.push_back({3625, axis, 360, true});
  if (std::abs(reversal_deg) > 1e-9) {
    entries.push_back({3627, axis, in_units(-sign * reversal_deg / unit)});
  }
  double before = in_units(totals.front());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double now = in_units(totals[k]);
    const long point = reference + first + static_cast<long>(k);
    // The first point of a turn is the last one again; the most negative point of a stroke has nothing before it.
    const double increment =
        k == 0 ? (turning ? in_units(totals.back()) - in_units(totals[totals.size() - 2]) : 0) : now - before;
    entries.push_back({kPitchBase + point, 0, increment});
    before = now;
  }
}

/// The node at the reference position, where the control's corrections begin from zero.
std::optional<std::size_t> zero_of(const std::vector<double>& nodes) {
  for (std::size_t k = 0; k < nodes.size(); ++k)
    if (std::abs(nodes[k]) < 1e-9) return k;
  return std::nullopt;
}

std::string value_text(const Entry& entry, Emission emission) {
  if (!emission.quantised) return shortest_text(entry.value);
  return entry.real ? fixed_text(entry.value, kPlaceDecimals) : fixed_text(entry.value, 0);
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
  std::vector<double> tilt_nodes, turn_nodes = even_nodes(0, 360, interval);
  for (double k = low; k <= std::max(high, low + 1); ++k) tilt_nodes.push_back(k * interval);
  const double turn_interval = turn_nodes[1];
  if (!zero_of(tilt_nodes))
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
  append_pitch(task, entries, false, interval, tilt_nodes,
               values(tilt.projector(tilt_at, zero_of(tilt_nodes)), held_tilt), tilt_reversal, emission);
  append_pitch(task, entries, true, turn_interval, turn_nodes,
               values(turn.projector(turn_at, zero_of(turn_nodes)), fit.turn_rad), turn_reversal, emission);
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

  std::string file = "%\n", g10 = "%\nO9000\nG10L52\n";
  for (const Entry& entry : entries) {
    const std::string number = std::to_string(entry.number),
                      axis = entry.axis == 0 ? "" : "A" + std::to_string(entry.axis);
    file += "N" + number + axis + "P" + value_text(entry, emission) + ";\n";
    g10 += "N" + number + (entry.axis == 0 ? "" : "P" + std::to_string(entry.axis)) + "R" +
           value_text(entry, emission) + "\n";
  }
  std::vector<TableFile> files = {{kParameterFile, file + "%\n"}};
  if (emission.for_the_control()) files.push_back({kG10File, g10 + "G11\nM30\n%\n"});
  return files;
}

/// Reads a parameter file as strictly as the control: what it would refuse is refused here.
std::vector<Entry> read_parameters(const TableFile& file) {
  std::vector<Entry> entries;
  std::size_t line_number = 0;
  int percent = 0;
  for (const std::string_view line : lines_of(file.text)) {
    ++line_number;
    const auto wrong = [&](const std::string& text) { throw InputError(file.name, line_number, text); };
    if (line == "%") {
      ++percent;
      continue;
    }
    if (line.empty()) wrong("an empty line");
    if (percent != 1) wrong("a block outside the two %");
    if (line.back() != ';') wrong("\"" + std::string(line) + "\": a block ends with ;");
    Entry entry;
    bool has_value = false;
    for (std::size_t k = 0; k + 1 < line.size();) {
      const char address = line[k];
      std::size_t end = k + 1;
      while (end + 1 < line.size() && std::string_view("+-.0123456789e").find(line[end]) != std::string_view::npos)
        ++end;
      const auto value = number_from(line.substr(k + 1, end - k - 1));
      if (!value) wrong(std::string("address ") + address + ": a number is wanted behind it");
      if (address == 'N' && k == 0 && *value >= 0 && *value < 100000) {
        entry.number = std::lround(*value);
      } else if (address == 'A' && k > 0 && *value >= 1 && *value <= 32) {
        entry.axis = std::lround(*value);
      } else if (address == 'P' && k > 0) {
        entry.value = *value;
        has_value = true;
      } else {
        wrong(std::string("address ") + address + ": N, A and P in capitals are wanted, in this order");
      }
      k = end;
    }
    if (entry.number == 0 || !has_value) wrong("N and P are wanted");
    entries.push_back(entry);
  }
  if (percent != 2) throw InputError(file.name, line_number, "a % at the beginning and one at the end are wanted");
  return entries;
}

class Fanuc : public PlayedCompensation {
 public:
  Fanuc(const std::vector<Entry>& entries, const CompensationTask& task, const std::string& file)
      : chain_(task.chain),
        machine_(task.machine),
        unit_(total_unit(task)),
        adds_(task.profile.answer("pitch_sign") != "subtract") {
    const Places nominal = nominal_places(task);
    Eigen::Vector3d tilt = nominal.tilt, turn = nominal.turn_from_tilt;
    const std::map<long, Pitch*> by_axis = {
        {std::lround(task.profile.number(std::string("axis_number_") + task.machine.tilt_letter())), &tilt_},
        {std::lround(task.profile.number("axis_number_C")), &turn_}};
    std::map<long, double> points;
    for (const Entry& e : entries) {
      if (e.number >= kPitchBase + 0 && e.number < 19000) points[e.number - kPitchBase] = e.value;
      if (e.number >= 19700 && e.number <= 19702) tilt[e.number - 19700] = e.value;
      if (e.number >= 19703 && e.number <= 19705) turn[e.number - 19703] = e.value;
      if (e.number == 19680 && e.value != 12)
        throw InputError(file, "19680 is " + shortest_text(e.value) + ", 12 (two table axes) is wanted");
      if (e.number < 3600 || e.number > 3630) continue;
      const auto found = by_axis.find(e.axis);
      if (found == by_axis.end())
        throw InputError(file, "N" + std::to_string(e.number) + ": axis " + std::to_string(e.axis) +
                                   " is not a rotary axis of this machine");
      Pitch& pitch = *found->second;
      if (e.number == 3620) pitch.reference = std::lround(std::clamp(e.value, -1e6, 1e6));
      if (e.number == 3621) pitch.lowest = std::lround(std::clamp(e.value, -1e6, 1e6));
      if (e.number == 3622) pitch.highest = std::lround(std::clamp(e.value, -1e6, 1e6));
      if (e.number == 3623) pitch.magnification = e.value;
      if (e.number == 3624) pitch.interval_deg = e.value;
      if (e.number == 3625) pitch.turn_deg = e.value;
      if (e.number == 3627) pitch.reversed = e.value;
    }
    for (Pitch* pitch : {&tilt_, &turn_}) {
      if (!(pitch->interval_deg > 0) || pitch->highest <= pitch->lowest || pitch->highest - pitch->lowest > 100000 ||
          pitch->reference < pitch->lowest || pitch->reference > pitch->highest)
        throw InputError(file,
                         "3620 to 3624: points from low to high about the reference, and an interval, are wanted");
      double sum = 0;
      for (long n = pitch->lowest; n <= pitch->highest; ++n) {
        if (!points.contains(n)) throw InputError(file, "pitch point " + std::to_string(n) + " is missing");
        pitch->increments[n] = points.at(n);
        if (n > pitch->lowest) sum += points.at(n);
      }
      if (pitch->turn_deg > 0 && std::abs(sum) > 1e-6)
        throw InputError(file,
                         "increments of a rotary axis add up to " + shortest_text(sum) + " in a turn, 0 is wanted");
    }
    Machine moved = machine_;
    moved.axes.at(moved.tilt_letter()).origin_mm = tilt;
    moved.axes.at('C').origin_mm = tilt + turn;
    believed_ = KinematicChain(moved);
  }

  AxisCorrection at(const Situation& s) const override {
    // With tool centre point control the linear axes go where the control believes the point to be.
    const Eigen::Vector3d w = chain_.r_from_w(s.at).inverse() * s.point_r_mm;
    return {believed_.r_from_w(s.at) * w - s.point_r_mm, correction(tilt_, s.at.a.in_degrees(), s.tilt_sense),
            correction(turn_, s.at.c.in_degrees(), s.turn_sense)};
  }

 private:
  /// The increments passed on the way from the reference, the change spread evenly between points.
  double correction(const Pitch& pitch, double degrees, int sense) const {
    if (pitch.turn_deg > 0) degrees -= pitch.turn_deg * std::floor(degrees / pitch.turn_deg);
    std::vector<double> nodes, totals;
    double total = 0, at_reference = 0;
    for (const auto& [point, increment] : pitch.increments) {
      if (!nodes.empty()) total += increment;
      nodes.push_back(static_cast<double>(point - pitch.reference) * pitch.interval_deg);
      totals.push_back(total);
      if (point == pitch.reference) at_reference = total;
    }
    double passed = interpolated(nodes, totals, Boundary::hold, degrees) - at_reference;
    if (sense < 0) passed += pitch.reversed;
    return (adds_ ? 1 : -1) * passed * pitch.magnification * unit_ * kDegree_rad;
  }

  KinematicChain chain_, believed_{chain_};
  Machine machine_;
  double unit_;
  bool adds_;
  Pitch tilt_, turn_;
};

std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task) {
  const auto found = std::ranges::find(files, kParameterFile, &TableFile::name);
  if (found == files.end()) throw InputError(kParameterFile, "missing");
  return std::make_unique<Fanuc>(read_parameters(*found), task, found->name);
}

std::string loading(const CompensationTask& task, const std::vector<TableFile>& files) {
  const bool reverses =
      std::ranges::any_of(files, [](const TableFile& f) { return f.text.find("\nN3627") != std::string::npos; });
  return "## Steps\n\n1. Save all parameters and pitch error data of the machine first.\n2. Parameter write enable; "
         "read in `" +
         std::string(kParameterFile) + "` (or run `" + kG10File +
         "`, which says the same).\n3. Power off and on (3620 to 3627), then return to the reference position.\n4. "
         "Tool centre point control: 19700 to 19705 hold where the axes "
         "were found, counted from R's origin as the machine file has it. Add your machine's own origin if it "
         "differs.\n" +
         (reverses ? "5. Bit 0 of 3605 = 1 for the axes that have a 3627: values differ with the sense of motion. The "
                     "file leaves 3605 alone, its other bits are the machine's.\n"
                   : "") +
         "\nThe detection unit is taken as " + shortest_text(total_unit(task)) +
         " deg (profile.detection_unit_deg). The numbers of 3623 and 3624 belong to it.\n\nUndo: read the saved data "
         "back in; power off and on.\n";
}

/// A pitch of seven units up and down again, 30 deg apart, on the way of each rotary axis from its reference.
std::vector<TableFile> commissioning(const CompensationTask& task) {
  std::string text = "%\n";
  for (const bool turning : {false, true}) {
    const long reference = kReference[turning ? 1 : 0], low = turning ? 0 : -3, high = turning ? 12 : 3;
    const std::string axis =
        "A" +
        shortest_text(task.profile.number(std::string("axis_number_") + (turning ? 'C' : task.machine.tilt_letter())));
    const auto line = [&](long number, const std::string& value) {
      text += "N" + std::to_string(number) + (number < kPitchBase ? axis : "") + "P" + value + ";\n";
    };
    line(3620, std::to_string(reference));
    line(3621, std::to_string(reference + low));
    line(3622, std::to_string(reference + high));
    line(3623, "1");
    line(3624, "30.0000");
    if (turning) line(3625, "360.0000");
    for (long k = low; k <= high; ++k)
      line(kPitchBase + reference + k, k == -1 || (turning && k == 2)   ? "7"
                                       : k == -2 || (turning && k == 3) ? "-7"
                                                                        : "0");
  }
  return {{"one_pitch_PARAM.TXT", text + "%\n"}};
}

}  // namespace

Controller fanuc_30i() {
  std::vector<ProfileNumber> numbers = {
      {"detection_unit_deg", "detection unit of the rotary axes", 0.0001, 1e-6, 0.01}};
  double number = 1;
  for (const char* axis : {"X", "Y", "Z", "A", "B", "C"}) {
    numbers.push_back({std::string("axis_number_") + axis, "controlled-axis number", number, 1, 32});
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
             "Load commissioning/one_pitch (3620 to 3624 of A and C, everything else 0), power off and on, reference, "
             "turn C from 0 to 60 deg and read it against an indicator: it stands 7 detection units further than "
             "without the table if increments are added, and back in place at 90."},
            {"pitch_interpolation",
             "Is the correction spread evenly between points (interpolated type)?",
             {"even"},
             "Move slowly from one point to the next and watch the compensation on the diagnosis screen."},
            {"pitch_blocks",
             "Does the control take pitch data as N10000 + point in a parameter file?",
             {"N10000 + point"},
             "Punch out the pitch data of the machine and compare."},
            {"tcp_vectors",
             "Do 19700-19702 lead to the first table axis and 19703-19705 from there to the second?",
             {"yes"},
             "Compare the machine's values with its drawing; change 19701 by 0.02 and see where G43.4 goes at a "
             "tilt."}},
           numbers},
      .spacings = {Angle::degrees(30), Angle::degrees(15), Angle::degrees(10), Angle::degrees(5), Angle::degrees(3)},
      .emit = emit,
      .play = play,
      .loading = loading,
      .commissioning = commissioning};
}

}  // namespace trunnion
