#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometric_errors/pose_error.h"
#include "kinematics/kinematic_chain.h"
#include "probing/observation.h"

namespace trunnion {

/// One scalar reading, linear in the pose error of its indexed position and in the unknowns of the measurement:
///   value = functional . Delta + sum coefficient * unknown + noise      (value: mm or rad, observed minus nominal)
/// contact: n . (p - R q_k) with [n, p x n] and the spot's offset s_k (Ibaraki, Iritani & Matsushita 2010, Eq. 7);
/// displacement: the same with the ball's three constants; rotation: [0, m] and the artifact's zero; pose: six rows,
/// taken at the target's origin, with the twelve constants of the instrument's and the target's mounting; surface: the
/// same as displacement along the inward normal, with the piece's rigid set-up and its size, as far as its shape tells
/// them apart.
struct Reading {
  std::uint32_t row = 0;   ///< of the observation set
  std::uint32_t pose = 0;  ///< index into LinearProblem::poses
  Vector6d functional = Vector6d::Zero();
  double value = 0;
  double sigma = 0;              ///< mm or rad
  bool angular = false;          ///< a rotation in rad, else a length in mm
  std::uint32_t first_term = 0;  ///< its terms in LinearProblem::terms
  std::uint32_t term_count = 0;
};

/// An unknown of the measurement and its coefficient in a reading.
using MeasurementTerm = std::pair<std::uint32_t, double>;

/// All readings of one fit, ready for least squares.
struct LinearProblem {
  const ObservationSet* observations = nullptr;  ///< must outlive the problem
  std::shared_ptr<const KinematicChain> chain;
  std::vector<PoseGroup> poses;
  std::vector<Reading> readings;
  std::vector<MeasurementTerm> terms;
  std::vector<std::string> unknowns;  ///< names of the measurement's unknowns: "spot 1S1", "zero of encoder" …
  std::vector<Situation> situations;  ///< one per observation row
  bool has_pose_kind = false;         ///< mounts of instrument and target are unknowns: only a smooth map can be fitted
  bool sigma_declared = true;         ///< false where the noise level has to be found from the data themselves

  std::span<const MeasurementTerm> terms_of(const Reading& reading) const {
    return {terms.data() + reading.first_term, reading.term_count};
  }
};

/// Mounting of an instrument that reads poses: the instrument's frame from R, and W from the target.
struct PoseMounting {
  Eigen::Isometry3d instrument_from_r = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d w_from_target = Eigen::Isometry3d::Identity();
};

/// Builds the problem. Throws InputError, naming file and line, for a contact set without the reference pose, a spot
/// that stands more than 1 mm or 3 deg from where its label puts it (a mixed-up label, unit or sense of rotation), or
/// no rows.
LinearProblem make_linear_problem(const ObservationSet& observations, const Machine& machine,
                                  const std::optional<PoseMounting>& mounting = {});

/// What the exact reading of a touch exceeds its linear form by, mm: the face, carried by T(Delta), met along the
/// commanded approach. Zero for other kinds. `spot_offset_mm` is the solved s_k.
double nonlinear_excess_mm(const LinearProblem& problem, const Reading& reading, const PoseError& delta,
                           double spot_offset_mm);

/// The mounting with which the nominal kinematics meets the observed poses best. Throws InputError for fewer than three
/// poses or poses that turn about a single axis only.
PoseMounting fit_pose_mounting(const ObservationSet& observations, const KinematicChain& chain);

}  // namespace trunnion
