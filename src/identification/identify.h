#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identification/earlier_map.h"
#include "identification/free_pose_fit.h"
#include "identification/outliers.h"
#include "model/effects/rotary_error_map.h"
#include "model/model.h"

namespace trunnion {

/// All unknowns in one fit, or a pose at each position first and the errors from the poses (Ibaraki et al. 2010).
enum class IdentificationMethod { joint, two_step };

/// An earlier map of the same machine, and how far the machine may have moved since.
struct EarlierMap {
  std::shared_ptr<const RotaryErrorMap> map;
  Drift drift;
};

/// How a map is identified.
struct IdentificationOptions {
  IdentificationMethod method = IdentificationMethod::joint;
  bool robust = true;                         ///< look for outliers and leave them out
  bool fill = false;                          ///< let the smooth fit stand in for freedoms that no reading determined
  std::string interpolation;                  ///< a method's name; empty: chosen by evidence
  std::optional<EarlierMap> earlier;          ///< is believed before the readings; the result is a smooth map then
  std::function<void(double)> progress = {};  ///< is told what share of the work is done, 0 … 1
};

/// Location errors found in the map, as if nothing else were wrong, and whether that would do.
struct LocationFinding {
  std::vector<std::string> symbols;
  std::vector<Unit> units;
  Eigen::VectorXd values;  ///< mm, rad
  Eigen::MatrixXd covariance;
  double chi_square = 0, freedom = 0, p_value = 1;  ///< of the pose errors that location errors do not explain
};

/// One error function as a whole.
struct ErrorFinding {
  std::string symbol;
  Unit unit = Unit::um;
  double largest = 0;      ///< the value of largest size, inside units
  double largest_std = 0;  ///< its standard uncertainty
  IndexedPosition largest_at;
  double rms_std = 0;
  double p_value = 1;           ///< that noise alone would give as much
  bool told_from_zero = false;  ///< p_value below 1 %
  std::size_t nodes = 0;        ///< of the function
  std::size_t unseen = 0;       ///< those of them that no reading determines; all: there is no value

  bool seen() const { return unseen < nodes; }
};

/// One angle whose poses were left out together, and how far they were missed.
struct LeftOutAngle {
  enum class Of { tilt, turn, check_poses } of = Of::turn;
  Angle angle;          ///< of all these poses; nothing for the check poses
  double score_um = 0;  ///< displacement at a lever of 100 mm, root mean square
  std::size_t poses = 0;
};

/// How well a way of interpolating predicts whole C columns, interior A rows and check poses left out.
struct InterpolationEvidence {
  std::string method;
  double rms_um = 0;    ///< of D
  double rms_urad = 0;  ///< of theta
  double score_um = 0;  ///< of the displacement at a lever of 100 mm: what is compared
  std::size_t poses = 0;
  std::vector<LeftOutAngle> angles;
};

/// How the readings agree with what was believed of an earlier map.
struct BeliefFinding {
  double chi_square = 0, freedom = 0;  ///< what the belief adds to what free poses would leave
  double p_value = 1;                  ///< that a machine which drifted as stated differs as much
  double misfit = 1;                   ///< reduced chi-square of the earlier map's nodes against the smooth basis
};

/// A map, and what the readings say of it.
struct IdentificationResult {
  Model model;  ///< the rotary error map alone
  IdentificationMethod method = IdentificationMethod::joint;
  std::size_t readings = 0, unknowns = 0, rank = 0;
  double condition = 0;
  double sigma_declared_um = 0;  ///< root mean square over the readings, rotations at a lever of 100 mm
  double sigma_found_um = 0;
  bool sigma_from_readings = false;  ///< none is declared: the readings alone say it, and chi-square says nothing
  double reduced_chi_square = 0, freedom = 0, chi_square_p = 1;
  double uncertainty_scale = 1;  ///< what the standard uncertainties were multiplied by where chi-square failed
  double worst_redundancy = 1;
  std::vector<Outlier> outliers;
  std::vector<Outlier> crowded;
  std::string crowd;
  std::vector<std::size_t> unchecked;  ///< readings that nothing can check
  std::vector<UnseenFreedom> unseen;
  std::vector<std::string> undetermined;            ///< unknowns of the measurement
  std::vector<IndexedPosition> interpolated_nodes;  ///< grid positions that were not probed
  std::optional<BeliefFinding> belief;              ///< with an earlier map
  LocationFinding location;
  std::vector<ErrorFinding> errors;
  std::vector<InterpolationEvidence> interpolation;
  std::string chosen_interpolation;
  LinearProblem problem;  ///< readings by line, poses
  SmoothFit smooth;
};

/// Error maps from observations, with their uncertainty (field: Ibaraki, Iritani & Matsushita 2010; joint least
/// squares). `observations` must outlive the result. Throws InputError for observations that cannot be used at all.
IdentificationResult identify(const ObservationSet& observations, const Machine& machine,
                              const IdentificationOptions& options = {});

}  // namespace trunnion
