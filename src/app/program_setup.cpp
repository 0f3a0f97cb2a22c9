#include "app/program_setup.h"

#include <cmath>
#include <utility>

#include "app/program_reading.h"
#include "app/table_folder.h"
#include "app/text_table.h"
#include "compensation/verification.h"
#include "error.h"
#include "io/observed_ranges.h"
#include "io/sha256.h"
#include "postproc/playback.h"

namespace trunnion {
namespace {

constexpr std::size_t kHashDigits = 12;
constexpr double kRoundingRoom = 1.5;  // of the last decimal: three words and two angles rounded

/// The dialect that the program's beginning or the machine tells.
std::string told_dialect_of(std::string_view head, const std::string& name, const Machine& machine) {
  if (std::string told = dialect_of(head, machine); !told.empty()) return told;
  throw UsageError(name +
                   ": its dialect is not told by the program nor by the machine's controller; --dialect is wanted");
}

double tool_length_mm(const Job& job, const KinematicChain& chain) {
  const bool tool_side = chain.has_rotary(Side::tool);
  if (job.tools.empty()) {
    if (tool_side) throw UsageError("this machine tilts the tool: a --job that gives the tool's length is wanted");
    return 0;
  }
  const double length = job.tools.begin()->second.length_mm;
  for (const auto& [number, tool] : job.tools)
    if (tool_side && tool.length_mm != length)
      throw UsageError(
          "this machine tilts the tool: tools of different lengths in one program are not corrected; give each its "
          "own");
  return length;
}

}  // namespace

ProgramSetup::ProgramSetup(const Machine& machine, const Model& model, Job job, const ProgramChoices& choices,
                           std::string_view head, std::string name, std::string_view model_text)
    : machine_(machine), model_(model), job_(std::move(job)), chain_(machine) {
  note_covariates();
  const Range<Angle> stroke =
      machine.tilt().range_angle.value_or(Range<Angle>{Angle::degrees(-360), Angle::degrees(360)});
  field_.emplace(model_, job_.covariates, stroke);
  if (!job_.tables.empty()) rest_.emplace(*field_, chain_, play_tables(files_in(job_.tables), machine, model));
  const ErrorField& errors = rest_ ? static_cast<const ErrorField&>(*rest_) : *field_;

  how_.dialect = choices.dialect.empty() ? told_dialect_of(head, name, machine) : choices.dialect;
  how_.name = std::move(name);
  how_.threads = choices.threads;
  how_.guard = guard_of(machine);
  how_.guard.tolerance_mm = 1e-3 * choices.tolerance_um;
  how_.scan = scan_settings(how_.dialect, machine, chain_, job_);
  how_.scan.decimals = choices.decimals;
  how_.scan.keep_going = choices.keep_going;
  how_.scan.tcp_forced = choices.tcp != "auto";
  if (how_.scan.tcp_forced) how_.scan.tcp = choices.tcp == "on";
  follow_what_errors_depend_on();
  how_.header = "model " + sha256_hex(model_text).substr(0, kHashDigits) + ", machine " + machine.name + ", serial " +
                machine.serial;
  room_mm_ = how_.guard.tolerance_mm + kRoundingRoom * std::pow(10.0, -choices.decimals);

  CorrectionSettings settings;
  settings.orientation = choices.orientation ? Orientation::corrected : Orientation::as_programmed;
  settings.largest_rotary_change = machine.limits.rotary_word;
  settings.tool_length_mm = tool_length_mm(job_, chain_);
  CorrectionSettings without = settings;
  without.tcp = ToolCentrePoint::off;
  with_tcp_.emplace(chain_, errors, settings);
  without_tcp_.emplace(chain_, errors, without);
}

/// Senses of X, Y, Z, and the time at feed from the job's on.
void ProgramSetup::follow_what_errors_depend_on() {
  for (const std::string& column : needed_covariates(model_)) {
    how_.scan.follow_senses |= column.ends_with("_dir") && column[0] >= 'X' && column[0] <= 'Z';
    how_.scan.follow_time |= column == "time_s" && job_.covariates.contains(column);
  }
  how_.scan.tool_length_mm = tool_length_mm(job_, chain_);
}

void ProgramSetup::note_covariates() {
  for (const std::string& column : needed_covariates(model_))
    if (!job_.covariates.contains(column) && !column.ends_with("_dir"))
      notes_.push_back(column + " is not known for this job: effects that depend on it stand at their zero");
  const ObservedRanges observed = observed_ranges(model_);
  for (auto& [column, value] : job_.covariates)
    if (const double end = held(observed, column, value); end != value) {
      notes_.push_back(column + ": " + formatted("%.6g", value) + " of this job was never observed; held at " +
                       formatted("%.6g", end));
      value = end;
    }
}

void ProgramSetup::expect_many_blocks() {
  if (!rest_ && !how_.scan.follow_time) field_->bake(chain_);
}

bool ProgramSetup::holds(const PlaybackResult& played) const { return played.after.largest_tip_mm <= room_mm_; }

}  // namespace trunnion
