#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/compensated_field.h"
#include "io/job_file.h"
#include "model/model.h"
#include "postproc/model_field.h"
#include "postproc/program_correction.h"

namespace trunnion {

/// What a user chooses about the correction of a program.
struct ProgramChoices {
  std::string dialect;       ///< empty: told by the program, or by the machine's controller
  std::string tcp = "auto";  ///< auto, on, off
  bool orientation = true;   ///< whether the rotary axes are corrected as well
  int decimals = 4;          ///< least, of corrected words, mm and deg
  int threads = 2;
  double tolerance_um = 0.2;  ///< tip error allowed between end points
  bool keep_going = false;    ///< copy blocks that are refused
};

/// All that correct_program and play_back are given, put together from machine, model, job and choices. `machine` and
/// `model` must outlive it.
class ProgramSetup {
 public:
  /// `head`: the beginning of the program, which may tell its dialect; `name` stands for the program in messages;
  /// `model_text`: the model's file, whose hash the header comment tells. Throws UsageError where the dialect is told
  /// by nothing, or the tool's length is wanted; InputError for tables of the job that cannot be read.
  ProgramSetup(const Machine& machine, const Model& model, Job job, const ProgramChoices& choices,
               std::string_view head, std::string name, std::string_view model_text);
  ProgramSetup(const ProgramSetup&) = delete;
  ProgramSetup& operator=(const ProgramSetup&) = delete;

  /// Bakes the model, which pays for programs of many blocks.
  void expect_many_blocks();

  const ProgramCorrection& how() const { return how_; }
  ProgramCorrection& how() { return how_; }
  const Corrector& with_tcp() const { return *with_tcp_; }
  const Corrector& without_tcp() const { return *without_tcp_; }
  const Job& job() const { return job_; }
  /// What the job leaves open, in sentences for people.
  const std::vector<std::string>& notes() const { return notes_; }
  /// Whether a correction played back is as good as tolerance and decimals promise.
  bool holds(const struct PlaybackResult& played) const;

 private:
  void follow_what_errors_depend_on();
  void note_covariates();

  const Machine& machine_;
  const Model& model_;
  Job job_;
  KinematicChain chain_;
  std::vector<std::string> notes_;
  std::optional<ModelField> field_;
  std::optional<CompensatedField> rest_;
  std::optional<Corrector> with_tcp_, without_tcp_;
  ProgramCorrection how_;
  double room_mm_ = 0;
};

}  // namespace trunnion
