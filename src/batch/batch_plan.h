#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace trunnion {

/// A machine of a fleet. Its model is identified from `observations`, or stands there as `model`.
struct BatchMachine {
  std::string name;  ///< explicit and unique: it names the results
  std::string machine_file, observations, model;
  friend bool operator==(const BatchMachine&, const BatchMachine&) = default;
};

/// A program that is corrected for every machine.
struct BatchProgram {
  std::string name, file, job;
  friend bool operator==(const BatchProgram&, const BatchProgram&) = default;
};

/// A test piece that is predicted for every machine, under the tables of `controllers` or none.
struct BatchPiece {
  std::string name, file;
  int draws = 0;
  bool first_order = false;
  bool corrected = false;
  std::vector<std::string> controllers;
  friend bool operator==(const BatchPiece&, const BatchPiece&) = default;
};

/// What is done for many machines: a plain value, in the order of its file.
struct BatchPlan {
  std::uint64_t seed = 1;
  std::vector<BatchMachine> machines;
  std::vector<std::string> controllers;  ///< tables for each
  std::vector<BatchProgram> programs;
  std::vector<BatchPiece> pieces;
  friend bool operator==(const BatchPlan&, const BatchPlan&) = default;
};

/// The command that a job calls.
enum class JobKind { identify, tables, correct, predict };

/// One call of the program, which depends on nothing but its inputs and on earlier jobs.
struct BatchJob {
  JobKind kind = JobKind::identify;
  std::string machine;              ///< name
  std::string label;                ///< "model", "tables.linuxcnc", "program.blade", "piece.cone.linuxcnc"
  int stage = 1;                    ///< jobs of one stage know nothing of each other
  std::string stem;                 ///< path of its results without an ending: DIR/NAME/LABEL
  std::string result;               ///< file that holds its summary
  std::vector<std::string> words;   ///< the call, without the program's name
  std::vector<std::string> inputs;  ///< files of the plan that it reads
  std::vector<std::size_t> after;   ///< indices of the jobs whose results it reads
  std::string name() const { return machine + "." + label; }
  friend bool operator==(const BatchJob&, const BatchJob&) = default;
};

/// The jobs of a plan with results below `folder`, machine by machine. A prediction with draws has a seed of its own,
/// made from the plan's seed and the job's name: adding a machine changes no other machine's numbers. Throws UsageError
/// for controllers of a piece that the plan makes no tables for.
std::vector<BatchJob> batch_jobs(const BatchPlan& plan, const std::string& folder);

/// The shell line of a job: makes its folder, calls `program`, keeps its output in STEM.txt and STEM.log, notes its
/// exit status and `fingerprint` in STEM.status and ends with that status.
std::string job_line(const BatchJob& job, const std::string& program, const std::string& fingerprint);

/// A word as a shell reads it back, in quotes where it needs them.
std::string shell_quoted(const std::string& word);

}  // namespace trunnion
