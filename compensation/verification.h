#pragma once

#include <functional>
#include <optional>

#include "compensation/controller.h"
#include "compensation/lost_terms.h"

namespace trunnion {

/// Deviations over a sample of poses.
struct Spread {
  double position_rms_mm = 0;
  double position_max_mm = 0;
  double orientation_rms_rad = 0;
};

/// The largest of what a set does at A = C = 0, over the corners of the volume: the machine is set up and its
/// compensation switched on there. Linear axes may go where the rotary ones carry the work.
struct AtRest {
  double linear_mm = 0, rotary_rad = 0;  ///< added to the commands
  double deviation_mm = 0;               ///< of the tool against the work, by all of them together
};

/// What a table set achieves, found by playing it over the working volume.
struct Verification {
  std::string controller;
  std::vector<std::string> unconfirmed;
  WorkingVolume volume;
  std::size_t poses = 0;
  Spread before;  ///< nothing compensated
  Spread ideal;   ///< all five axes corrected as well as they can
  Spread tables;  ///< the set as the control plays it
  /// Root mean squares of what the position loses: to what the format cannot say, to the distance of nodes, to
  /// rounding.
  double lost_to_format_mm = 0;
  double lost_to_spacing_mm = 0;
  double lost_to_quantisation_mm = 0;
  std::vector<LostTerm> lost_terms;  ///< what makes up the loss to the format
  Angle spacing;
  std::optional<AtRest> at_reference;  ///< none where the volume does not reach it
  Situation worst;                     ///< the pose with the largest deviation under the tables
  std::vector<std::string> files;

  bool load_ready() const { return unconfirmed.empty(); }
};

/// What is left of the model's errors at the poses of `sample` under a compensation as a control plays it.
Spread spread(const Model& model, const KinematicChain& chain, const std::vector<Situation>& sample,
              const PlayedCompensation& played);

/// verification.json (CONTRACT, Tables), and the same for people.
std::string verification_json(const Verification& verification, const Machine& machine);
std::string verification_text(const Verification& verification, const Machine& machine);

/// A complete set: tables (named *.DRAFT.* while a question is open), LOADING.md, verification.json, and the
/// commissioning tests of open questions.
struct TableSet {
  std::vector<TableFile> files;
  Verification verification;
};

/// Projects, writes, reads back, plays and judges. The spacing is the coarsest that costs less than 0.05 um or a
/// twentieth of what the format loses anyway, unless the options say one. Throws RangeError where a limit of the
/// control or of the machine file is exceeded, RefusalError where the set would not make the machine better.
/// `progress` is told what is being done, for people.
TableSet make_tables(const Controller& controller, const Machine& machine, const Model& model,
                     const TableOptions& options, const std::function<void(const std::string& step)>& progress = {});

/// The folder that make_tables wrote, played: what `predict` and `identify --active` need.
std::unique_ptr<PlayedCompensation> play_tables(const std::vector<TableFile>& files, const Machine& machine,
                                                const Model& model);

}  // namespace trunnion
