#include "app/piece_cutting.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/program_reading.h"
#include "app/table_folder.h"
#include "app/text_table.h"
#include "compensation/controller.h"
#include "compensation/verification.h"
#include "error.h"
#include "io/machine_file.h"
#include "model/effects/rotary_error_map.h"
#include "postproc/correction.h"
#include "postproc/model_field.h"
#include "postproc/piece_program.h"
#include "postproc/playback.h"

namespace trunnion {
namespace {

constexpr double kStep_mm = 0.1, kStep_deg = 0.1;         ///< between two positions of a program's path
constexpr Length kRoundedWords = Length::micrometres(2);  ///< three decimals of a length, and of an angle on 0.1 m

Range<Angle> stroke(const Machine& machine) {
  return machine.tilt().range_angle.value_or(Range<Angle>{Angle::degrees(-180), Angle::degrees(180)});
}

CorrectionSettings settings(const CuttingSetup& setup, ToolCentrePoint tcp) {
  return {.tcp = tcp,
          .largest_rotary_change = setup.machine.limits.rotary_word,
          .tool_length_mm = setup.piece.tool.length.in_millimetres()};
}

/// Of each line of a corrected program, the line of the original that it stands for, both counted from 1.
std::vector<std::uint64_t> original_lines(const std::string& corrected, const ProgramCorrectionResult& result) {
  const auto lines = static_cast<std::size_t>(std::ranges::count(corrected, '\n')) + 1;
  std::vector<std::uint64_t> original = {0};
  auto insertion = result.inserted.begin();
  for (std::uint64_t number = 1; original.size() <= lines; ++number) {
    if (original.size() == result.header_line) original.push_back(number);
    original.push_back(number);
    if (insertion == result.inserted.end() || insertion->line != number) continue;
    original.insert(original.end(), insertion->count, number);
    ++insertion;
  }
  return original;
}

/// Changes a path position by position. Senses of motion stay those that it means: a correction's own steps to and fro
/// are smaller than what an axis loses, and `correct` reckons alike.
template <class Correction>
std::vector<ToolPosition> recommanded(const CuttingSetup& setup, std::vector<ToolPosition> path, Correction of) {
  const Eigen::Vector3d gauge(0, 0, -setup.piece.tool.length.in_millimetres());
  for (ToolPosition& p : path) {
    const AxisCorrection correction = of(p);
    const IndexedPosition to{p.at.a + Angle::radians(correction.tilt_rad),
                             p.at.c + Angle::radians(correction.turn_rad)};
    p.tip_r_mm += correction.linear_mm + (setup.chain.r_from_t(to) * gauge - setup.chain.r_from_t(p.at) * gauge);
    p.at = to;
  }
  return path;
}

}  // namespace

PieceCutting::PieceCutting(const CuttingSetup& setup) : setup_(setup) {
  for (const auto& [name, value] : setup_.job.covariates) {
    if (name == "time_s") known_.time_s = value;
    if (name == "temperature_C") known_.temperature_C = value;
    names_.push_back(name);
    values_.push_back(value);
  }
  known_.extra = {&names_, values_.data()};
}

std::vector<std::string> PieceCutting::unknown_moments() const {
  const std::string tilt_dir = std::string(1, setup_.machine.tilt_letter()) + "_dir";
  std::vector<std::string> notes;
  for (const std::string& column : needed_covariates(setup_.model)) {
    const bool timed = column == "time_s" && setup_.piece.feed_mm_per_min;
    const bool sense = column.size() == 5 && column.ends_with("_dir") && column[0] >= 'X' && column[0] <= 'Z';
    if (sense || column == tilt_dir || column == "C_dir" || timed || setup_.job.covariates.contains(column)) continue;
    notes.push_back("effects of " + column + " stand at their zero: the piece does not tell it" +
                    (column == "time_s" ? " (path.feed_mm_per_min would)" : ""));
  }
  return notes;
}

std::optional<std::string> PieceCutting::beyond_reach(std::span<const ToolPosition> path) const {
  const Machine& machine = setup_.machine;
  const RotaryErrorMap* map = setup_.model.rotary_map();
  const auto& stroke = machine.tilt().range_angle;
  const auto number = [](double value) { return formatted("%.6g", value); };
  const auto said = [&](const ToolPosition& p, char axis, double value, const std::string& what, double low,
                        double high, const std::string& unit) {
    return "at phi " + number(Angle::radians(p.phi_rad).in_degrees()) + " deg " + axis + " stands at " + number(value) +
           " " + unit + ", " + what + " " + number(low) + " to " + number(high) + " " + unit;
  };
  for (const ToolPosition& p : path) {
    const auto tilt_said = [&](const std::string& what, const Range<Angle>& range) {
      return said(p, machine.tilt_letter(), p.at.a.in_degrees(), what, range.low.in_degrees(), range.high.in_degrees(),
                  "deg");
    };
    if (map != nullptr && !map->surface().covers(p.at.a)) return tilt_said("probed is", map->surface().a_range());
    if (stroke && (p.at.a < stroke->low || p.at.a > stroke->high)) return tilt_said("its stroke is", *stroke);
    const Eigen::Vector3d slides = slides_mm(setup_.chain, p.tip_r_mm, p.at, Length());  // as X Y Z words say it
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto& range = machine.axes.at("XYZ"[k]).range_length;
      if (!range || (slides[k] >= range->low.in_millimetres() && slides[k] <= range->high.in_millimetres())) continue;
      return said(p, "XYZ"[k], slides[k], "its stroke is", range->low.in_millimetres(), range->high.in_millimetres(),
                  "mm");
    }
  }
  return std::nullopt;
}

ScanSettings PieceCutting::scan() const {
  ScanSettings scan = scan_settings(setup_.dialect, setup_.machine, setup_.chain, setup_.job);
  if (setup_.planned && !dialect(setup_.dialect).says_tcp) scan.tcp = scan.tcp_forced = true;
  return scan;
}

PieceCutting::ReadPath PieceCutting::read(const std::string& program, const std::string& name) const {
  const KinematicChain& chain = setup_.chain;
  const ModelField field(setup_.model, setup_.job.covariates, stroke(setup_.machine));
  const Corrector in_w(chain, field, settings(setup_, ToolCentrePoint::on));
  const Corrector in_r(chain, field, settings(setup_, ToolCentrePoint::off));
  const Eigen::Isometry3d cone_from_w = w_from_cone(setup_.piece.cone).inverse(Eigen::Isometry);
  ReadPath read;
  for (const PlayedPlace& place : played_places(opened(program), scan(), kStep_mm, kStep_deg, setup_.dialect)) {
    const Corrector& nominal = place.tcp ? in_w : in_r;
    const Commanded commanded{{place.at[0], place.at[1], place.at[2]},
                              {Angle::degrees(place.at[kTilt]), Angle::degrees(place.at[kTurn])}};
    ToolPosition p{.at = commanded.rotary, .tip_r_mm = nominal.nominal_tip_r(commanded)};
    p.nominal.tip_w_mm = nominal.nominal_tip_w(commanded);
    p.nominal.axis_w =
        chain.r_from_w(p.at).linear().transpose() * (chain.r_from_t(p.at).linear() * Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d in_cone =
        cone_from_w * (p.nominal.tip_w_mm + setup_.piece.tool.overhang.in_millimetres() * p.nominal.axis_w);
    p.phi_rad = std::atan2(in_cone.y(), in_cone.x());
    read.path.push_back(p);
    read.line.push_back(place.line);
  }
  if (read.path.empty()) throw InputError(name, "no block that moves at feed with every axis known");
  set_senses(read.path, chain, setup_.piece.tool.length, kRoundedWords);
  set_times(read.path, setup_.piece);
  return read;
}

std::vector<ToolPosition> PieceCutting::path_of(const std::string& program, const std::string& name) const {
  refuse_other_serial(program, setup_.machine.serial, name);
  return read(program, name).path;
}

std::string PieceCutting::planned_program(std::span<const ToolPosition> path) const {
  PieceProgramStyle style{setup_.dialect, setup_.machine.tilt_letter(), scan().control, setup_.machine.turn().modulo};
  if (const auto g54 = setup_.job.work_offsets_mm.find("G54"); g54 != setup_.job.work_offsets_mm.end())
    style.work_offset_mm = Eigen::Vector3d(g54->second.data());
  return piece_program(setup_.piece, path, setup_.chain, style);
}

CorrectedPieceProgram PieceCutting::corrected(const std::string& program, const std::string& name) const {
  const ModelField field(setup_.model, setup_.job.covariates, stroke(setup_.machine));
  const Corrector with_tcp(setup_.chain, field, settings(setup_, ToolCentrePoint::on));
  const Corrector without_tcp(setup_.chain, field, settings(setup_, ToolCentrePoint::off));
  ProgramCorrection how;
  how.dialect = setup_.dialect;
  how.scan = scan();
  how.guard = guard_of(setup_.machine);
  how.name = name;
  how.header = "machine " + setup_.machine.name + ", serial " + setup_.machine.serial;
  how.keep_insertions = true;
  CorrectedPieceProgram corrected;
  const ProgramCorrectionResult result = correct_program(
      opened(program), [&](std::string_view part) { corrected.text += part; }, with_tcp, without_tcp, how);

  ReadPath sent = read(corrected.text, name + ", corrected");
  const ReadPath meant = read(program, name);
  const std::vector<std::uint64_t> original = original_lines(corrected.text, result);
  std::size_t at = 0;
  for (std::size_t i = 0; i < sent.path.size(); ++i) {
    while (at + 1 < meant.path.size() && meant.line[at + 1] <= original[sent.line[i]]) ++at;
    sent.path[i].linear_sense = meant.path[at].linear_sense;
    sent.path[i].tilt_sense = meant.path[at].tilt_sense;
    sent.path[i].turn_sense = meant.path[at].turn_sense;
  }
  corrected.path = std::move(sent.path);
  return corrected;
}

std::vector<ToolPosition> PieceCutting::under_tables(const std::vector<ToolPosition>& path,
                                                     const std::string& folder) const {
  const std::unique_ptr<PlayedCompensation> played = play_tables(files_in(folder), setup_.machine, setup_.model);
  return recommanded(setup_, path, [&](const ToolPosition& p) {
    return played->at(situation_at(p, setup_.piece.tool.length, known_));
  });
}

std::vector<ToolPosition> PieceCutting::ideally_corrected(const std::vector<ToolPosition>& path) const {
  return recommanded(setup_, path, [&](const ToolPosition& p) {
    return ideal_correction(setup_.model, setup_.chain, setup_.machine.limits,
                            situation_at(p, setup_.piece.tool.length, known_));
  });
}

}  // namespace trunnion
