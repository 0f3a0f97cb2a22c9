#pragma once

#include <Eigen/Core>
#include <vector>

#include "discovery/projection.h"
#include "model/catalogue.h"

namespace trunnion {

/// An effect that may be missing, and what it would do to every reading (whitened, one column a parameter).
struct Candidate {
  EffectPtr effect;
  Eigen::MatrixXd columns;
  Eigen::VectorXd scale;      ///< inside value of a parameter per unit of its column
  Eigen::VectorXd precision;  ///< prior precision of each column; empty: free
  double members = 1;         ///< of its family that were tried: shapes, orders, bodies
};

/// The candidate of a catalogue effect: its columns are functional . basis(situation) / sigma, in file units of the
/// parameters so that the numbers are tame.
Candidate make_candidate(const LinearProblem& problem, EffectPtr effect);

/// Columns and priors of several candidates beside each other; `without` leaves one out.
EffectColumns side_by_side(const std::vector<Candidate>& candidates, Eigen::Index rows,
                           std::size_t without = static_cast<std::size_t>(-1));
/// The same with one more at the end.
EffectColumns with_one_more(EffectColumns first, const Candidate& candidate);

/// How a candidate fares against what a base leaves.
struct CandidateScore {
  double gain = 0;              ///< y' P Z (Z' P Z)^+ Z' P y: chi-square with `rank` degrees where it is absent
  double rank = 0;              ///< columns that the base leaves visible
  double visible_fraction = 0;  ///< ||P Z|| / ||Z||
  double p_value = 1;           ///< F test against the scatter that is left
};
CandidateScore score(const Projection& base, const Eigen::MatrixXd& columns);

/// Half the gain, less half of log(freedom) for each visible column and the log of the members that were tried: the
/// log likelihood by which models are compared (Schwarz 1978, with the family's size as its prior).
double evidence(const CandidateScore& score, const Projection& base, double members);

/// Z' P Z on its visible directions: W with W' (Z' P Z) W = I.
struct VisibleSpace {
  Eigen::MatrixXd whitening;
  double visible_fraction = 0;
};
VisibleSpace visible_space(const Eigen::MatrixXd& gram_z, const Eigen::MatrixXd& gram_pz);
/// The score from W and Z' P y.
CandidateScore score_in(const VisibleSpace& space, const Eigen::VectorXd& product, const Projection& base);

/// Moves the shape of `candidate` to where its gain is largest: periods, time constants and moments, the whole numbers
/// among them by strides that halve.
Candidate refined(const LinearProblem& problem, const Projection& base, const Candidate& candidate);

}  // namespace trunnion
