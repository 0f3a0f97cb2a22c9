#pragma once

#include <Eigen/Core>
#include <string>
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
};

/// The candidate of a catalogue effect.
Candidate make_candidate(const LinearProblem& problem, EffectPtr effect);

/// functional . basis(situation) / sigma of every reading, in file units of the parameters so that the numbers are
/// tame.
Eigen::MatrixXd effect_columns(const LinearProblem& problem, const Effect& effect);

/// How a candidate fares against what a base leaves.
struct CandidateScore {
  double gain = 0;              ///< y' P Z (Z' P Z)^+ Z' P y
  double rank = 0;              ///< columns that the base leaves visible
  double visible_fraction = 0;  ///< ||P Z|| / ||Z||
  double p_value = 1;           ///< F test against the scatter that is left
  double log_likelihood = 0;    ///< gained, for the declared noise: what model choice compares
};
CandidateScore score(const Projection& base, const Eigen::MatrixXd& columns);

/// Scores of all candidates at once.
std::vector<CandidateScore> scores(const Projection& base, const std::vector<Candidate>& candidates);

/// The largest canonical correlations between a candidate and each of the others outside the base.
std::vector<double> canonical_correlations(const Projection& base, const Candidate& candidate,
                                           const std::vector<Candidate>& others);

/// Moves the shape of `candidate` to where its gain is largest, within `span` of each shape number (a factor).
Candidate refined(const LinearProblem& problem, const Projection& base, const Candidate& candidate);

}  // namespace trunnion
