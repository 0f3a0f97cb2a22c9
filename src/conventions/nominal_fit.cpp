#include "conventions/nominal_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

constexpr double kRadiansAtMost = 6.3;  // commands beyond a turn in rad are deg
constexpr std::size_t kMostRows = 600;  // of a long log every n-th: a wrong sense shows in a dozen

/// Rows whose place is told in R, and that belong to a spot seen at another position as well.
std::vector<std::size_t> telling_rows(const ObservationSet& set) {
  std::map<std::uint32_t, std::set<std::pair<double, double>>> positions;
  const auto tells = [](const Observation& o) {
    return o.kind == ReadingKind::contact || o.kind == ReadingKind::displacement;
  };
  for (const Observation& o : set.rows)
    if (tells(o)) positions[o.point].insert({o.at.a.in_degrees(), o.at.c.in_degrees()});
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < set.rows.size(); ++i)
    if (tells(set.rows[i]) && positions[set.rows[i].point].size() > 1) rows.push_back(i);
  if (rows.size() <= kMostRows) return rows;
  std::vector<std::size_t> some;
  for (std::size_t k = 0; k < kMostRows; ++k) some.push_back(rows[k * rows.size() / kMostRows]);
  return some;
}

IndexedPosition read_as(IndexedPosition at, const AngleReading& reading) {
  const auto one = [&](Angle angle, bool reversed) {
    const Angle meant = reading.radians ? Angle::radians(angle.in_degrees()) : angle;
    return reversed ? -meant : meant;
  };
  return {one(at.a, reading.tilt_reversed), one(at.c, reading.turn_reversed)};
}

NominalFit fit(const ObservationSet& set, const std::vector<std::size_t>& rows, const KinematicChain& chain,
               const AngleReading& reading) {
  std::vector<std::size_t> joints;
  for (std::size_t j = 0; j < chain.rotary_joints().size(); ++j)
    if (chain.rotary_joints()[j].side == Side::workpiece) joints.push_back(j);
  std::map<std::uint32_t, Eigen::Index> spot;
  for (const std::size_t i : rows) spot.emplace(set.rows[i].point, 0);
  Eigen::Index next = 3 * static_cast<Eigen::Index>(joints.size());
  for (auto& [point, column] : spot) column = next, next += 3;

  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(3 * n, next);
  Eigen::VectorXd places(3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Observation& o = set.rows[rows[static_cast<std::size_t>(k)]];
    const IndexedPosition at = read_as(o.at, reading);
    Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
    Eigen::Vector3d place = o.position_mm;  // less what the lines of the file make of it
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const Eigen::Matrix3d motion = chain.motion(joints[j], at);
      const Eigen::Matrix3d of_line = turned * (Eigen::Matrix3d::Identity() - motion);
      design.block<3, 3>(3 * k, 3 * static_cast<Eigen::Index>(j)) = of_line;
      place -= of_line * chain.rotary_joints()[joints[j]].origin_mm;
      turned = turned * motion;
    }
    design.block<3, 3>(3 * k, spot.at(o.point)) = turned;
    places.segment<3>(3 * k) = place;
  }
  const LeastSquares solver(design);
  const Eigen::VectorXd x = solver.solve(places);
  NominalFit result{.reading = reading,
                    .rms_mm = std::sqrt((places - design * x).squaredNorm() / static_cast<double>(n)),
                    .line_offset_mm = {},
                    .letters = {}};
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const RotaryJoint& joint = chain.rotary_joints()[joints[j]];
    Eigen::Vector3d off = x.segment<3>(3 * static_cast<Eigen::Index>(j));
    off -= off.dot(joint.direction) * joint.direction;
    result.line_offset_mm.push_back(off);
    result.letters.push_back(joint.letter);
  }
  return result;
}

}  // namespace

std::vector<NominalFit> nominal_fits(const ObservationSet& observations, const Machine& machine) {
  const KinematicChain chain(machine);
  const std::vector<std::size_t> rows = telling_rows(observations);
  if (rows.empty() || !chain.has_rotary(Side::workpiece)) return {};
  const auto on_table = [&](std::size_t joint) { return chain.rotary_joints()[joint].side == Side::workpiece; };
  const bool may_be_radians = std::ranges::all_of(observations.rows, [](const Observation& o) {
    return std::max(std::abs(o.at.a.in_degrees()), std::abs(o.at.c.in_degrees())) <= kRadiansAtMost;
  });
  std::vector<NominalFit> fits;
  for (const bool radians : {false, true})
    for (const bool tilt : {false, true})
      for (const bool turn : {false, true}) {
        if ((radians && !may_be_radians) || (tilt && !on_table(chain.tilt_index())) ||
            (turn && !on_table(chain.turn_index())))
          continue;
        fits.push_back(fit(observations, rows, chain, {tilt, turn, radians}));
      }
  return fits;
}

}  // namespace trunnion
