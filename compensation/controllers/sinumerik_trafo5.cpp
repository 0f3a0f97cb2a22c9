#include "compensation/controllers/sinumerik_trafo5.h"

#include <Eigen/Geometry>
#include <cmath>

#include "compensation/controllers/sinumerik_assignments.h"
#include "compensation/controllers/sinumerik_tables.h"
#include "compensation/number_text.h"
#include "error.h"

namespace trunnion {
namespace {

constexpr int kOffsetDecimals = 7;      // mm
constexpr int kDirectionDecimals = 12;  // a direction of length 1; 1e-12 at 1 m is nothing
constexpr double kClosed_mm = 1e-6;

/// "$MC_TRAFO5_AXIS1_" + the transformation's number.
std::string datum(const CompensationTask& task, const std::string& name) {
  return "$MC_TRAFO5_" + name + "_" + shortest_text(task.profile.number("trafo5_number"));
}

/// An axis as a line.
struct Line {
  Eigen::Vector3d point_mm, direction;
};

/// The lines of both axes with their location errors, at A = C = 0. Each error moves its own axis and all that it
/// carries, so that C's line is moved by A's errors and then, in A's frame, by its own.
std::pair<Line, Line> moved_lines(const CompensationTask& task, const Effect& location) {
  PoseError of_tilt, of_turn;
  for (const Parameter& p : location.parameters()) {
    PoseError& error = p.name[3] == 'C' ? of_turn : of_tilt;
    const auto component = static_cast<Eigen::Index>(std::string("XYZABC").find(p.name[1]));
    if (component < 3) error.translation_mm[component] = p.value;
    if (component >= 3) error.rotation_rad[component - 3] = p.value;
  }
  const Axis &a = task.machine.tilt(), &c = task.machine.turn();
  const Eigen::Isometry3d tilt_moved =
      Eigen::Translation3d(a.origin_mm) * transform(of_tilt) * Eigen::Translation3d(-a.origin_mm);
  const Eigen::Isometry3d turn_moved =
      tilt_moved * Eigen::Translation3d(c.origin_mm) * transform(of_turn) * Eigen::Translation3d(-c.origin_mm);
  return {{tilt_moved * a.origin_mm, tilt_moved.linear() * a.direction.normalized()},
          {turn_moved * c.origin_mm, turn_moved.linear() * c.direction.normalized()}};
}

}  // namespace

bool sets_trafo5(const CompensationTask& task) {
  return !task.chain.has_rotary(Side::tool) && !task.chain.turn_carries_tilt() &&
         task.profile.answer("trafo5_axes") != "not to be set";
}

TableFile trafo5_file(const CompensationTask& task, const Effect& location, Emission emission) {
  const auto [tilt, turn] = moved_lines(task, location);
  const double sense = task.profile.answer("trafo5_axes") == "against the axis" ? -1 : 1;
  std::string text = sinumerik::header(task, "TRAFO5_INI");
  text += "; generic transformation, $MC_TRAFO_TYPE_" + shortest_text(task.profile.number("trafo5_number")) +
          "=40; lengths from R's origin\n";
  const auto vector = [&](const std::string& name, const Eigen::Vector3d& v, int decimals) {
    for (Eigen::Index k = 0; k < 3; ++k)
      text += datum(task, name) + "[" + std::to_string(k) +
              "]=" + (emission.quantised ? fixed_text(v[k], decimals) : shortest_text(v[k])) + "\n";
  };
  vector("BASE_TOOL", tilt.point_mm, kOffsetDecimals);
  vector(task.profile.answer("trafo5_joint"), turn.point_mm - tilt.point_mm, kOffsetDecimals);
  vector("PART_OFFSET", -turn.point_mm, kOffsetDecimals);
  vector("AXIS1", sense * tilt.direction, kDirectionDecimals);
  vector("AXIS2", sense * turn.direction, kDirectionDecimals);
  return {kTrafo5File, text + "M17\n"};
}

KinematicChain read_trafo5(const TableFile& file, const CompensationTask& task) {
  const SinumerikAssignments data(file);
  const auto vector = [&](const std::string& name) {
    Eigen::Vector3d v;
    for (Eigen::Index k = 0; k < 3; ++k) v[k] = data.number(datum(task, name), std::to_string(k));
    if (!(v.norm() < 1e5)) throw InputError(file.name, datum(task, name) + ": 100 m and more");
    return v;
  };
  const Eigen::Vector3d first = vector("BASE_TOOL"), joint = vector(task.profile.answer("trafo5_joint")),
                        part = vector("PART_OFFSET");
  if (const double open = (first + joint + part).norm(); !(open < kClosed_mm))
    throw InputError(file.name,
                     "BASE_TOOL, JOINT_OFFSET and PART_OFFSET add up to " + shortest_text(open) + " mm, 0 is wanted");
  // A workpiece that turns about v is a tool that turns about -v; which of the two the data name is the profile's.
  const double sense = task.profile.answer("trafo5_axes") == "against the axis" ? -1 : 1;
  const auto direction = [&](const std::string& name) {
    const Eigen::Vector3d v = vector(name);
    if (!(std::abs(v.norm() - 1) < 1e-3))
      throw InputError(file.name,
                       datum(task, name) + ": a direction of length " + shortest_text(v.norm()) + ", 1 is wanted");
    return Eigen::Vector3d(sense * v);
  };
  Machine believed = task.machine;
  Axis &tilt = believed.axes.at(believed.tilt_letter()), &turn = believed.axes.at('C');
  tilt.origin_mm = first;
  tilt.direction = direction("AXIS1");
  turn.origin_mm = first + joint;
  turn.direction = direction("AXIS2");
  return KinematicChain(believed);
}

std::string trafo5_loading(const CompensationTask& task) {
  const std::string n = shortest_text(task.profile.number("trafo5_number"));
  return "`" + std::string(kTrafo5File) + "` holds machine data of the five-axis transformation number " + n +
         " (generic, MD24100 $MC_TRAFO_TYPE_" + n +
         " = 40; types 32 to 35 have no axis vectors). Lengths are counted from R's origin as the machine file has "
         "it:\n"
         "add where that stands on your machine to BASE_TOOL and take it from PART_OFFSET. Note the old values of "
         "MD24500, MD24550, MD24558 (or MD24560), MD24570 and MD24572;\n"
         "enter the new ones, NEW CONFIG or reset, and see with a sphere on the table that TRAORI holds it. Tables "
         "and vectors belong together: one without the other\nmakes the machine worse.\n";
}

std::vector<ProfileItem> trafo5_questions() {
  return {
      {"trafo5_axes",
       "Do the vectors TRAFO5_AXIS1 and AXIS2 of a table point against the axis about which the workpiece turns, or "
       "along it, or are they not to be set (a fixed type, no option)?",
       {"against the axis", "along the axis", "not to be set"},
       "Read MD24570 of the machine as delivered: against, if it is -1 0 0 where a positive command turns the "
       "workpiece right-handed about +X. Then add 0.0001 to MD24572[0] and, under TRAORI at {A} 0, go to a point that "
       "stands at X +100 when C is at 180 deg: Z is 0.02 mm higher than before if against, lower if along."},
      {"trafo5_joint",
       "Which machine data hold the way from the first to the second axis of a table?",
       {"JOINT_OFFSET_PART", "JOINT_OFFSET"},
       "See which of MD24558 and MD24560 the list of the control names so, and whether 0.02 in its element 1 "
       "(and minus that in element 1 of MD24500) moves Y by +0.04 under TRAORI when C turns by 180 deg at {A} 0."}};
}

}  // namespace trunnion
