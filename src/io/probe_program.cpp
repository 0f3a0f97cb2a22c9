#include "io/probe_program.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "error.h"
#include "io/csv.h"
#include "kinematics/kinematic_chain.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr std::string_view kHeader = "trunnion-probe-log";
// touch, point, artifact, A, C, A_dir, C_dir, repeat, time, nx, ny, nz, ball radius, x, y, z of the ball's centre
constexpr std::size_t kFields = 16;
constexpr double kUnitLength = 1e-3;  // of an approach, as printed

/// Writes the blocks of one program.
class Writer {
 public:
  Writer(const ObservationSet& plan, const Machine& machine, const ProbeMoves& moves)
      : plan_(plan), machine_(machine), moves_(moves), radius_mm_(machine.probe.ball_radius.in_millimetres()) {
    double highest = -1e9;
    for (const Observation& o : plan.rows) highest = std::max(highest, o.position_mm.norm());
    safe_mm_ = highest + moves.clearance_mm;  // whatever stands on the table, however it is turned
    if (const auto& stroke = machine.axes.at('Z').range_length)
      safe_mm_ = std::min(safe_mm_, stroke->high.in_millimetres());
  }

  std::string run(const std::string& log_name) {
    block("(Probing plan: " + std::to_string(plan_.rows.size()) + " touches; machine " + said(machine_.name) + ")");
    block("(X Y Z are R's coordinates in the active work offset; tool length to the ball's centre.)");
    block("(Prove it with the probe far away before the first run.)");
    block("G21 G17 G90 G94 G40 G80");
    block("(LOGOPEN," + log_name + ")");
    block("(LOG," + std::string(kHeader) + ",1," + said(machine_.name) + "," + said(machine_.serial) + ")");
    block("G0 Z" + fixed_text(safe_mm_, 4));
    const Observation* before = nullptr;
    for (const Observation& o : plan_.rows) {
      if (before == nullptr || !(before->at == o.at) || before->tilt_sense != o.tilt_sense ||
          before->turn_sense != o.turn_sense)
        turn_to(o, before);
      touch(o);
      before = &o;
    }
    block("(LOGCLOSE)");
    block("G0 Z" + fixed_text(safe_mm_, 4));
    block("M2");
    return std::move(text_);
  }

 private:
  void block(const std::string& line) { text_ += line + "\n"; }

  static std::string said(std::string name) {
    for (char& c : name)
      if (c == '(' || c == ')' || c == ',' || c == '#' || c == '%') c = ' ';
    return name;
  }
  static std::string label(const std::string& name) {
    if (name.find_first_of("(),#%\n") != std::string::npos)
      throw UsageError("--nc linuxcnc: the label \"" + name + "\" cannot stand in a LOG comment");
    return name;
  }

  /// To a position, past it first where an axis has to come from the other side.
  void turn_to(const Observation& o, const Observation* before) {
    const char tilt = machine_.tilt_letter();
    const double a = o.at.a.in_degrees(), c = o.at.c.in_degrees();
    const auto way = [](double to, double from) { return to > from + 1e-9 ? 1 : (to < from - 1e-9 ? -1 : 0); };
    const double a_from = before != nullptr ? before->at.a.in_degrees() : a - o.tilt_sense * 1.0;
    const double c_from = before != nullptr ? before->at.c.in_degrees() : c - o.turn_sense * 1.0;
    const bool a_past = before == nullptr || (way(a, a_from) != o.tilt_sense &&
                                              !(way(a, a_from) == 0 && before->tilt_sense == o.tilt_sense));
    const bool c_past = before == nullptr || (way(c, c_from) != o.turn_sense &&
                                              !(way(c, c_from) == 0 && before->turn_sense == o.turn_sense));
    block("G0 Z" + fixed_text(safe_mm_, 4));
    if (a_past || c_past) {
      const double a_over = a_past ? a - o.tilt_sense * moves_.overshoot_deg : a;
      const double c_over = c_past ? c - o.turn_sense * moves_.overshoot_deg : c;
      if (const auto& stroke = machine_.tilt().range_angle;
          stroke && (a_over < stroke->low.in_degrees() || a_over > stroke->high.in_degrees()))
        throw RefusalError("plan: " + std::string(1, tilt) + " cannot come to " + fixed_text(a, 3) +
                           " deg from the other side: " + fixed_text(a_over, 3) + " deg is beyond its stroke");
      block("G0 " + std::string(1, tilt) + fixed_text(a_over, 5) + " C" + fixed_text(c_over, 5));
    }
    block("G0 " + std::string(1, tilt) + fixed_text(a, 5) + " C" + fixed_text(c, 5));
  }

  void touch(const Observation& o) {
    const Eigen::Vector3d centre = o.position_mm - radius_mm_ * o.direction;  // of the ball where it meets the face
    const Eigen::Vector3d start = centre - moves_.standoff_mm * o.direction;
    const Eigen::Vector3d end = centre + moves_.overtravel_mm * o.direction;
    for (const Eigen::Vector3d* place : {&start, &end}) check(*place, o);
    block("G0 X" + fixed_text(start.x(), 4) + " Y" + fixed_text(start.y(), 4));
    block("G0 Z" + fixed_text(start.z(), 4));
    block("G38.2 X" + fixed_text(end.x(), 4) + " Y" + fixed_text(end.y(), 4) + " Z" + fixed_text(end.z(), 4) + " F" +
          fixed_text(moves_.feed_mm_per_min, 1));
    block("(LOG,touch," + label(plan_.points[o.point]) + "," +
          (plan_.artifacts.empty() ? std::string() : label(plan_.artifacts[o.artifact])) + "," +
          fixed_text(o.at.a.in_degrees(), 5) + "," + fixed_text(o.at.c.in_degrees(), 5) + "," +
          std::to_string(o.tilt_sense) + "," + std::to_string(o.turn_sense) + "," + std::to_string(o.repeat) + "," +
          fixed_text(o.time_s, 1) + "," + fixed_text(o.direction.x(), 9) + "," + fixed_text(o.direction.y(), 9) + "," +
          fixed_text(o.direction.z(), 9) + "," + fixed_text(radius_mm_, 4) + ",#5061,#5062,#5063)");
    block("G0 X" + fixed_text(start.x(), 4) + " Y" + fixed_text(start.y(), 4) + " Z" + fixed_text(start.z(), 4));
    block("G0 Z" + fixed_text(safe_mm_, 4));
  }

  void check(const Eigen::Vector3d& place, const Observation& o) const {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto& stroke = machine_.axes.at("XYZ"[k]).range_length;
      if (stroke && (place[k] < stroke->low.in_millimetres() || place[k] > stroke->high.in_millimetres()))
        throw RefusalError("plan: spot " + plan_.points[o.point] + " at " + fixed_text(o.at.a.in_degrees(), 3) + ", " +
                           fixed_text(o.at.c.in_degrees(), 3) + " deg: " + "XYZ"[k] + " " + fixed_text(place[k], 3) +
                           " mm is beyond its stroke");
    }
  }

  const ObservationSet& plan_;
  const Machine& machine_;
  const ProbeMoves& moves_;
  double radius_mm_, safe_mm_ = 0;
  std::string text_;
};

}  // namespace

std::string linuxcnc_probe_program(const ObservationSet& plan, const Machine& machine, const ProbeMoves& moves,
                                   const std::string& log_name) {
  if (KinematicChain(machine).has_rotary(Side::tool))
    throw RefusalError(
        "--nc linuxcnc: a rotary axis of this machine carries the tool; X, Y and Z of the probe would turn with it");
  return Writer(plan, machine, moves).run(log_name);
}

ObservationSet parse_probe_log(std::string_view text, const std::string& name, const Machine& machine,
                               const ReadingProgress& progress) {
  ObservationSet set{.files = {name}};
  set.has_repeat = set.has_time = set.has_tilt_sense = set.has_turn_sense = true;
  std::map<std::string, std::uint32_t, std::less<>> points, artifacts;
  const auto intern = [](auto& known, std::vector<std::string>& labels, std::string_view label) {
    const auto [entry, added] = known.emplace(std::string(label), static_cast<std::uint32_t>(labels.size()));
    if (added) labels.emplace_back(label);
    return entry->second;
  };
  std::size_t line = 0;
  bool header = false;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view row = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++line;
    if (progress && line % kLinesBetweenProgress == 0) progress(line);
    if (row.empty()) continue;
    std::vector<std::string_view> fields;
    for (std::size_t at = 0; at <= row.size();) {
      const std::size_t comma = std::min(row.find(',', at), row.size());
      fields.push_back(trimmed(row.substr(at, comma - at)));
      at = comma + 1;
    }
    if (fields[0] == kHeader) {
      if (fields.size() != 4 || fields[1] != "1")
        throw InputError(name, line, std::string(kHeader) + ",1,MACHINE,SERIAL is wanted");
      if (!machine.serial.empty() && fields[3] != machine.serial)
        throw RefusalError(name + ":" + std::to_string(line) + ": probed on serial " + std::string(fields[3]) +
                           ", the machine file is that of " + machine.serial);
      header = true;
      continue;
    }
    if (!header) throw InputError(name, line, "the log begins with " + std::string(kHeader) + ",1,MACHINE,SERIAL");
    if (fields[0] != "touch" || fields.size() != kFields)
      throw InputError(name, line,
                       "touch and " + std::to_string(kFields - 1) + " fields are wanted, " +
                           std::to_string(fields.size()) + " found");
    std::array<double, kFields> value{};
    for (std::size_t k = 3; k < kFields; ++k) {
      const std::optional<double> number = parse_number(fields[k]);
      if (!number)
        throw InputError(
            name, line,
            "field " + std::to_string(k + 1) + ": \"" + std::string(fields[k]) + "\" found, a number is wanted");
      value[k] = *number;
    }
    for (const std::size_t k : {5U, 6U})
      if (std::abs(value[k]) != 1)
        throw InputError(name, line, "field " + std::to_string(k + 1) + ": a sense of motion, 1 or -1, is wanted");
    if (value[7] < 0 || value[7] != std::floor(value[7]) || value[7] > 1e6)
      throw InputError(name, line, "field 8: a pass, 0 or more, is wanted");
    Observation o{.line = static_cast<std::uint32_t>(line),
                  .at = {Angle::degrees(value[3]), Angle::degrees(value[4])},
                  .point = intern(points, set.points, fields[1]),
                  .artifact = intern(artifacts, set.artifacts, fields[2])};
    o.direction = {value[9], value[10], value[11]};
    if (std::abs(o.direction.norm() - 1) > kUnitLength)
      throw InputError(name, line, "fields 10 to 12: a unit vector is wanted");
    o.direction.normalize();
    o.position_mm = Eigen::Vector3d(value[13], value[14], value[15]) + value[12] * o.direction;
    o.tilt_sense = static_cast<int>(value[5]);
    o.turn_sense = static_cast<int>(value[6]);
    o.repeat = static_cast<int>(value[7]);
    o.time_s = value[8];
    set.rows.push_back(o);
  }
  if (set.rows.empty()) throw InputError(name, "no touch in it");
  return set;
}

}  // namespace trunnion
