#include "identification/linear_problem.h"

#include <cmath>
#include <unordered_map>

#include "error.h"
#include "linear_algebra/factors.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kMislabelled_mm = 1.0;
const double kMisdirected = std::sin(Angle::degrees(3).in_radians());

/// Collects readings while the observations are walked through.
class Builder {
 public:
  Builder(const ObservationSet& observations, const Machine& machine) : set_(observations), machine_(machine) {
    problem_.observations = &observations;
    problem_.chain = std::make_shared<KinematicChain>(machine);
    problem_.poses = pose_groups(observations);
    problem_.situations = situations(observations);
    problem_.readings.reserve(observations.rows.size());
    pose_of_row_.resize(observations.rows.size());
    for (std::size_t g = 0; g < problem_.poses.size(); ++g)
      for (const std::size_t r : problem_.poses[g].rows) pose_of_row_[r] = static_cast<std::uint32_t>(g);
  }

  LinearProblem build(const std::optional<PoseMounting>& mounting) {
    if (set_.rows.empty()) throw InputError(set_.files.front(), "no observations");
    bool contact_seen = false;
    for (const Observation& row : set_.rows) {
      problem_.has_pose_kind = problem_.has_pose_kind || row.kind == ReadingKind::pose;
      contact_seen = contact_seen || row.kind == ReadingKind::contact;
    }
    if (problem_.has_pose_kind) mounting_ = mounting ? *mounting : fit_pose_mounting(set_, *problem_.chain);
    if (contact_seen) find_spots();
    if (!set_.cuts.empty()) find_set_up();
    for (std::size_t r = 0; r < set_.rows.size(); ++r) add(r);
    return std::move(problem_);
  }

 private:
  struct Spot {
    bool known = false;
    bool at_reference = false;
    Eigen::Vector3d place_w_mm, normal_w;
    std::uint32_t unknown = 0;
  };

  void find_spots() {
    spots_.resize(set_.points.size());
    bool reference = false;
    for (std::size_t r = 0; r < set_.rows.size(); ++r) {
      const Observation& row = set_.rows[r];
      if (row.kind != ReadingKind::contact) continue;
      const bool at_reference = problem_.poses[pose_of_row_[r]].reference;
      reference = reference || at_reference;
      Spot& spot = spots_[row.point];
      if (spot.known && (spot.at_reference || !at_reference)) continue;
      const Eigen::Isometry3d w_from_r = problem_.chain->r_from_w(row.at).inverse(Eigen::Isometry);
      const std::uint32_t unknown = spot.known ? spot.unknown : name_unknown("spot " + set_.points[row.point]);
      spot = {true, at_reference, w_from_r * row.position_mm, w_from_r.linear() * row.direction, unknown};
    }
    if (!reference)
      throw InputError(set_.files.front(), std::string("no touch at the reference pose ") + machine_.tilt_letter() +
                                               " 0, C 0; the spots must be probed there");
  }

  std::uint32_t name_unknown(const std::string& name) {
    problem_.unknowns.push_back(name);
    return static_cast<std::uint32_t>(problem_.unknowns.size() - 1);
  }

  Reading begin(std::size_t r, double sigma, bool angular) {
    return {.row = static_cast<std::uint32_t>(r),
            .pose = pose_of_row_[r],
            .sigma = sigma,
            .angular = angular,
            .first_term = static_cast<std::uint32_t>(problem_.terms.size())};
  }
  void finish(Reading reading) {
    reading.term_count = static_cast<std::uint32_t>(problem_.terms.size()) - reading.first_term;
    problem_.readings.push_back(reading);
  }

  double length_sigma(const Observation& row) const {
    return row.sigma > 0 ? row.sigma : machine_.probe.sigma.in_millimetres();
  }

  void add(std::size_t r) {
    switch (set_.rows[r].kind) {
      case ReadingKind::contact:
        return add_contact(r);
      case ReadingKind::displacement:
        return add_displacement(r);
      case ReadingKind::rotation:
        return add_rotation(r);
      case ReadingKind::pose:
        return add_pose(r);
      case ReadingKind::surface:
        return add_surface(r);
      case ReadingKind::none:
        break;
    }
  }

  void add_contact(std::size_t r) {
    const Observation& row = set_.rows[r];
    const Spot& spot = spots_[row.point];
    const Eigen::Isometry3d r_from_w = problem_.chain->r_from_w(row.at);
    const Eigen::Vector3d nominal = r_from_w * spot.place_w_mm, normal = r_from_w.linear() * spot.normal_w;
    if ((normal - row.direction).norm() > kMisdirected)
      throw InputError(set_.place(r),
                       "nx,ny,nz: spot " + set_.points[row.point] + " faces (" +
                           printed("%.4f, %.4f, %.4f", normal.x(), normal.y(), normal.z()) +
                           ") at this pose; a mixed-up label, or a wrong sense of rotation in the machine file");
    Reading reading = begin(r, length_sigma(row), false);
    const double aligned = normal.dot(row.direction);
    reading.value = normal.dot(row.position_mm - nominal) / aligned;  // along the approach, from the nominal face
    if (std::abs(reading.value) > kMislabelled_mm)
      throw InputError(set_.place(r), "spot " + set_.points[row.point] +
                                          printed(" is found %.3f mm from where it should stand", reading.value) +
                                          "; a mixed-up label, unit or machine");
    reading.functional << normal / aligned, row.position_mm.cross(normal) / aligned;
    problem_.terms.emplace_back(spot.unknown, 1 / aligned);
    finish(reading);
  }

  void add_displacement(std::size_t r) {
    const Observation& row = set_.rows[r];
    Reading reading = begin(r, length_sigma(row), false);
    reading.value = row.value;
    reading.functional << row.direction, row.position_mm.cross(row.direction);
    const Eigen::Vector3d in_w = problem_.chain->r_from_w(row.at).linear().transpose() * row.direction;
    const std::string label = set_.points.empty() ? "" : set_.points[row.point];
    const auto [entry, added] = balls_.emplace(row.point, static_cast<std::uint32_t>(problem_.unknowns.size()));
    if (added)
      for (const char* axis : {"X", "Y", "Z"}) name_unknown("place of ball " + label + " in " + axis);
    for (int k = 0; k < 3; ++k) problem_.terms.emplace_back(entry->second + static_cast<std::uint32_t>(k), in_w[k]);
    finish(reading);
  }

  void add_rotation(std::size_t r) {
    const Observation& row = set_.rows[r];
    // A rotary reading without its own sigma: what the probe's would be at a lever of 100 mm.
    Reading reading = begin(r, row.sigma > 0 ? row.sigma : machine_.probe.sigma.in_millimetres() / 100, true);
    problem_.sigma_declared = problem_.sigma_declared && row.sigma > 0;
    reading.value = row.value;
    reading.functional << Eigen::Vector3d::Zero(), row.direction;
    const auto [entry, added] = zeros_.emplace(row.artifact, static_cast<std::uint32_t>(problem_.unknowns.size()));
    if (added)
      name_unknown("zero of " + (set_.artifacts.empty() ? std::string("rotation") : set_.artifacts[row.artifact]));
    problem_.terms.emplace_back(entry->second, 1.0);
    finish(reading);
  }

  void add_pose(std::size_t r) {
    const Observation& row = set_.rows[r];
    if (mounts_.empty())
      for (const char* body : {"instrument", "target"})
        for (const char* freedom : {"X", "Y", "Z", "A", "B", "C"})
          mounts_.push_back(name_unknown(std::string("mounting of the ") + body + " in " + freedom));
    problem_.sigma_declared = problem_.sigma_declared && row.sigma > 0;
    const Eigen::Isometry3d nominal = problem_.chain->r_from_w(row.at);
    Eigen::Isometry3d measured = Eigen::Isometry3d::Identity();
    measured.linear() = row.orientation.toRotationMatrix();
    measured.translation() = row.position_mm;
    const Eigen::Isometry3d in_r = mounting_.instrument_from_r.inverse(Eigen::Isometry) * measured;
    const Eigen::Vector3d target = nominal * mounting_.w_from_target.translation();
    const Eigen::AngleAxisd turn(in_r.linear() * (nominal * mounting_.w_from_target).linear().transpose());
    const Eigen::Vector3d rotation = turn.angle() * turn.axis();
    const Matrix6d carried = adjoint(nominal);
    const double sigma = row.sigma > 0 ? row.sigma : 0.1;
    for (int k = 0; k < 6; ++k) {
      Reading reading = begin(r, k < 3 ? sigma : sigma / 200, k >= 3);
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(k % 3);
      if (k < 3)
        reading.functional << axis, target.cross(axis);
      else
        reading.functional << Eigen::Vector3d::Zero(), axis;
      reading.value = k < 3 ? axis.dot(in_r.translation() - target) : axis.dot(rotation);
      for (Eigen::Index m = 0; m < 6; ++m) {
        problem_.terms.emplace_back(mounts_[static_cast<std::size_t>(m)], reading.functional[m]);
        problem_.terms.emplace_back(mounts_[static_cast<std::size_t>(6 + m)], reading.functional.dot(carried.col(m)));
      }
      finish(reading);
    }
  }

  using SetUp = Eigen::Matrix<double, 7, 1>;

  static Vector6d surface_functional(const Observation& row) {
    Vector6d functional;
    functional << row.direction, row.position_mm.cross(row.direction);
    return functional;
  }

  /// What a displacement of the piece in W (mm, and rotations at a lever of 100 mm) and its size do to a row.
  SetUp set_up_row(const Observation& row) const {
    SetUp v;
    v << adjoint(problem_.chain->r_from_w(row.at)).transpose() * surface_functional(row), 1;
    v.segment<3>(3) /= 100;
    return v;
  }

  /// A body of revolution does not show all of its set-up: only what it shows becomes an unknown, as columns square to
  /// one another of root mean square 1.
  void find_set_up() {
    constexpr double kShown = 1e-8;  // of the largest eigenvalue
    Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
    double count = 0;
    for (const Observation& row : set_.rows) {
      if (row.kind != ReadingKind::surface) continue;
      normal += set_up_row(row) * set_up_row(row).transpose();
      ++count;
    }
    const SymmetricEigen eigen(normal / std::max(1.0, count));
    for (Eigen::Index k = 6; k >= 0; --k) {
      const double square = eigen.eigenvalues()[k];
      if (square <= kShown * eigen.eigenvalues()[6]) break;
      set_up_.push_back(eigen.eigenvectors().col(k) / std::sqrt(square));
      set_up_unknown_.push_back(name_unknown("set-up and size of the piece, " + std::to_string(7 - k)));
    }
  }

  void add_surface(std::size_t r) {
    const Observation& row = set_.rows[r];
    Reading reading = begin(r, length_sigma(row), false);
    reading.value = row.value;
    reading.functional = surface_functional(row);
    const SetUp shown = set_up_row(row);
    for (std::size_t k = 0; k < set_up_.size(); ++k)
      problem_.terms.emplace_back(set_up_unknown_[k], set_up_[k].dot(shown));
    finish(reading);
  }

  const ObservationSet& set_;
  const Machine& machine_;
  LinearProblem problem_;
  std::vector<std::uint32_t> pose_of_row_;
  std::vector<Spot> spots_;
  std::unordered_map<std::uint32_t, std::uint32_t> balls_, zeros_;
  std::vector<std::uint32_t> mounts_;
  std::vector<SetUp> set_up_;
  std::vector<std::uint32_t> set_up_unknown_;
  PoseMounting mounting_;
};

}  // namespace

LinearProblem make_linear_problem(const ObservationSet& observations, const Machine& machine,
                                  const std::optional<PoseMounting>& mounting) {
  return Builder(observations, machine).build(mounting);
}

double nonlinear_excess_mm(const LinearProblem& problem, const Reading& reading, const PoseError& delta,
                           double spot_offset_mm) {
  const Observation& row = problem.observations->rows[reading.row];
  if (row.kind != ReadingKind::contact) return 0;
  // The functional's head is the face's nominal normal over its cosine to the approach.
  const Eigen::Vector3d normal = reading.functional.head<3>().normalized();
  const Eigen::Vector3d level = row.position_mm - reading.value * row.direction;  // on the nominal face
  const Eigen::Vector3d on_face = level + spot_offset_mm * normal;
  const Eigen::Vector3d moved = on_face + displacement_mm(delta, on_face);
  const Eigen::Vector3d turned = transform(delta).linear() * normal;
  const double exact = turned.dot(moved - level) / turned.dot(row.direction);
  return exact - reading.functional.dot(delta.vector()) - spot_offset_mm / normal.dot(row.direction);
}

}  // namespace trunnion
