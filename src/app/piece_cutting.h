#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/job_file.h"
#include "postproc/motion.h"
#include "testpiece/machining.h"

namespace trunnion {

inline constexpr int kStepsPerTurn = 7200;  ///< of a planned path, unless said: 0.05 deg, an arc of 0.03 mm

/// What a test piece is cut with.
struct CuttingSetup {
  const Machine& machine;
  const Model& model;
  const TestPiece& piece;
  const KinematicChain& chain;
  const Job& job;
  std::string dialect = "linuxcnc";  ///< of its programs
  bool planned = false;  ///< they are planned here: the tip is held, whatever the machine file says of others
};

/// A corrected program, and where it puts the tool, read from its text; the senses of motion are those of the program
/// that was corrected.
struct CorrectedPieceProgram {
  std::string text;
  std::vector<ToolPosition> path;
};

/// Where the commands of a test piece bring the tool, by whichever way they are given: a program's text, or a path
/// under a compensation. What it was given must outlive it.
class PieceCutting {
 public:
  explicit PieceCutting(const CuttingSetup& setup);
  PieceCutting(const PieceCutting&) = delete;
  PieceCutting& operator=(const PieceCutting&) = delete;

  /// How programs of the piece are read.
  ScanSettings scan() const;
  /// What the job tells of the moment; `time_s` is that of the beginning.
  const Situation& known() const { return known_; }

  /// What effects of the model depend on and neither piece nor job tells, in sentences for people.
  std::vector<std::string> unknown_moments() const;
  /// Where a path asks for a tilt that was not probed, or goes beyond a stroke, in words; empty where it does not.
  std::optional<std::string> beyond_reach(std::span<const ToolPosition> path) const;

  /// Where a program puts the tool, read from its text; `name` stands for it in messages. Time runs by the piece's
  /// feed. Throws InputError for one that never moves at feed with every axis known, RefusalError for one that was
  /// corrected for another serial number.
  std::vector<ToolPosition> path_of(const std::string& program, const std::string& name) const;
  /// The path as a program of the setup's dialect, counted from the job's G54.
  std::string planned_program(std::span<const ToolPosition> path) const;
  /// What `trunnion correct` would write.
  CorrectedPieceProgram corrected(const std::string& program, const std::string& name) const;

  /// A path as the tables of a folder change it, read back and played on the control that its verification names.
  std::vector<ToolPosition> under_tables(const std::vector<ToolPosition>& path, const std::string& folder) const;
  /// A path corrected as well as five axes can.
  std::vector<ToolPosition> ideally_corrected(const std::vector<ToolPosition>& path) const;

  std::vector<ToolInWorkpiece> actual(std::span<const ToolPosition> path) const {
    return actual_tools(path, setup_.chain, setup_.model, setup_.piece.tool.length, known_);
  }

 private:
  struct ReadPath {
    std::vector<ToolPosition> path;
    std::vector<std::uint64_t> line;  ///< of the program, one a position
  };
  ReadPath read(const std::string& program, const std::string& name) const;

  CuttingSetup setup_;
  Situation known_;
  std::vector<std::string> names_;  ///< of the job's covariates, to which known_ points
  std::vector<double> values_;
};

}  // namespace trunnion
