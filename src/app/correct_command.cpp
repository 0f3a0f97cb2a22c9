#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/compensated_field.h"
#include "app/program_reading.h"
#include "app/table_folder.h"
#include "app/text_table.h"
#include "compensation/verification.h"
#include "error.h"
#include "io/job_file.h"
#include "io/json_text.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observed_ranges.h"
#include "io/output_file.h"
#include "io/provenance.h"
#include "io/sha256.h"
#include "io/text_file.h"
#include "postproc/dialect.h"
#include "postproc/model_field.h"
#include "postproc/playback.h"
#include "postproc/program_correction.h"

namespace trunnion {
namespace {

constexpr std::size_t kHashDigits = 12;
constexpr double kWorthBaking_bytes = 4e6;  // a bake costs as much as correcting this without
constexpr double kRoundingRoom = 1.5;       // of the last decimal: three words and two angles rounded

struct Options {
  std::string machine, model, job, input, output, dialect, tcp = "auto", orientation = "on", report;
  int decimals = 4, threads = 2;
  double tolerance_um = 0.2;
  bool keep_going = false, only_position = false;
};

/// A file as a source of bytes.
OpenProgram program_file(const std::string& path) {
  return [path]() -> ReadBytes {
    const std::shared_ptr<std::FILE> file(std::fopen(path.c_str(), "rb"), [](std::FILE* f) {
      if (f != nullptr) std::fclose(f);
    });
    if (!file) throw InputError(path, std::strerror(errno));
    std::setvbuf(file.get(), nullptr, _IONBF, 0);
    return [file, path](char* buffer, std::size_t size) {
      const std::size_t n = std::fread(buffer, 1, size, file.get());
      if (n < size && std::ferror(file.get()) != 0) throw InputError(path, "cannot be read");
      return n;
    };
  };
}

/// In bytes; 0 for what is no file.
double file_size(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<double>(size);
}

/// The dialect that a program's beginning or the machine tells.
std::string told_dialect_of(const std::string& path, const Machine& machine) {
  std::string head(std::size_t{1} << 16, '\0');
  const ReadBytes read = program_file(path)();
  head.resize(read(head.data(), head.size()));
  if (std::string told = dialect_of(head, machine); !told.empty()) return told;
  throw UsageError(path +
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

/// How far a long program has come, on a terminal.
class ProgressLine {
 public:
  ProgressLine(const std::string& path, const Talk& talk)
      : shown_(!talk.quiet && ::isatty(STDERR_FILENO) != 0), size_(file_size(path)) {}
  ~ProgressLine() {
    if (written_) std::fprintf(stderr, "\r\033[K");
  }
  void at(std::uint64_t bytes) {
    if (!shown_) return;
    const double now = seconds();
    if (now < next_) return;
    next_ = now + 0.5;
    const double done = static_cast<double>(bytes);
    std::fprintf(stderr, "\r%3.0f %%, %.0f MB/s, %.0f s left ", 100 * done / std::max(size_, 1.0), 1e-6 * done / now,
                 now * (size_ - done) / std::max(done, 1.0));
    written_ = true;
  }

 private:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  bool shown_, written_ = false;
  double size_, next_ = 1;
};

nlohmann::json path_json(const PathError& e) {
  return {{"position_rms_um", 1e3 * e.rms_tip_mm},
          {"position_max_um", 1e3 * e.largest_tip_mm},
          {"position_max_line", e.tip_line},
          {"orientation_rms_urad", 1e6 * e.rms_tilt_rad},
          {"orientation_max_urad", 1e6 * e.largest_tilt_rad},
          {"orientation_max_line", e.tilt_line}};
}

nlohmann::json along_json(const PathTrace& along) {
  nlohmann::json j = {{"lines_per_stretch", along.lines_per_stretch()}};
  for (const char* column :
       {"line", "position_before_um", "position_after_um", "orientation_before_urad", "orientation_after_urad"})
    j[column] = nlohmann::json::array();
  for (const PathStretch& s : along.stretches()) {
    j["line"].push_back(s.line);
    j["position_before_um"].push_back(1e3 * s.tip_before_mm);
    j["position_after_um"].push_back(1e3 * s.tip_after_mm);
    j["orientation_before_urad"].push_back(1e6 * s.tilt_before_rad);
    j["orientation_after_urad"].push_back(1e6 * s.tilt_after_rad);
  }
  return j;
}

nlohmann::json summary_json(const Options& o, const ProgramCorrection& how, const ProgramCorrectionResult& result,
                            const std::optional<PlaybackResult>& played) {
  const CorrectionCounts& c = result.counts;
  nlohmann::json json = {
      {"format", "trunnion-correction"},
      {"version", 1},
      {"nc_program", o.input.substr(o.input.find_last_of('/') + 1)},
      {"dialect", how.dialect},
      {"tcp",
       how.scan.tcp_forced || !dialect(how.dialect).says_tcp ? (how.scan.tcp ? "on" : "off") : "as the program says"},
      {"orientation", o.only_position ? "off" : o.orientation},
      {"changed", c.changed()},
      {"lines", c.lines},
      {"corrected_blocks", c.corrected_blocks},
      {"copied_moves", c.copied_moves},
      {"changed_words", c.changed_words},
      {"added_words", c.added_words},
      {"inserted_blocks", c.inserted_blocks},
      {"blocks_beyond_tolerance", c.beyond_tolerance},
      {"largest_deviation_um", 1e3 * c.largest_deviation_mm},
      {"largest_tilt_urad", 1e6 * c.largest_tilt_rad},
      {"largest_residual_tilt_urad", 1e6 * c.largest_residual_rad},
      {"largest_C_correction_deg", Angle::radians(c.largest_c_correction_rad).in_degrees()},
      {"largest_change_per_block_um", 1e3 * c.largest_position_change_mm},
      {"largest_rotary_change_per_block_deg", Angle::radians(c.largest_rotary_change_rad).in_degrees()}};
  json["refused"] = nlohmann::json::array();
  for (const Refusal& r : result.refusals) json["refused"].push_back({{"line", r.line}, {"reason", r.reason}});
  if (played)
    json["playback"] = {{"moves", played->moves},
                        {"places", played->samples},
                        {"before", path_json(played->before)},
                        {"after", path_json(played->after)},
                        {"along", along_json(played->along)}};
  return json;
}

std::string summary_text(const ProgramCorrectionResult& result, const std::optional<PlaybackResult>& played) {
  const CorrectionCounts& c = result.counts;
  std::string text = std::to_string(c.lines) + " lines, " + std::to_string(c.corrected_blocks) + " moves corrected, " +
                     std::to_string(c.copied_moves) + " copied (an axis not yet programmed), " +
                     std::to_string(c.changed_words) + " words changed, " + std::to_string(c.added_words) + " added, " +
                     std::to_string(c.inserted_blocks) + " blocks inserted\n";
  text += "Largest deviation " + formatted("%.2f um", 1e3 * c.largest_deviation_mm) +
          formatted(", tilt %.2f urad", 1e6 * c.largest_tilt_rad) +
          formatted(", tilt left %.2f urad", 1e6 * c.largest_residual_rad) +
          formatted(", change of C %.4f deg\n", Angle::radians(c.largest_c_correction_rad).in_degrees());
  if (!c.changed()) text += "Nothing had to be changed: the output is the input\n";
  if (played)
    text += text_table(
        {{"played back", "tip rms um", "tip max um", "at line", "axis rms urad", "axis max urad", "at line"},
         {"before", formatted("%.3f", 1e3 * played->before.rms_tip_mm),
          formatted("%.3f", 1e3 * played->before.largest_tip_mm), std::to_string(played->before.tip_line),
          formatted("%.3f", 1e6 * played->before.rms_tilt_rad),
          formatted("%.3f", 1e6 * played->before.largest_tilt_rad), std::to_string(played->before.tilt_line)},
         {"after", formatted("%.3f", 1e3 * played->after.rms_tip_mm),
          formatted("%.3f", 1e3 * played->after.largest_tip_mm), std::to_string(played->after.tip_line),
          formatted("%.3f", 1e6 * played->after.rms_tilt_rad), formatted("%.3f", 1e6 * played->after.largest_tilt_rad),
          std::to_string(played->after.tilt_line)}});
  return text;
}

int run(const Options& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  const std::string model_bytes = read_text(o.model);
  const Model model = parse_model(model_bytes, o.model, machine);
  check_same_machine(model, machine, o.model);
  Job job;
  if (!o.job.empty())
    job = read_job(o.job);
  else
    talk.warn("no --job: work offsets are zero, and the program's zero is where W has its own");

  const KinematicChain chain(machine);
  for (const std::string& column : needed_covariates(model))
    if (!job.covariates.contains(column) && column != "C_dir" &&
        column != std::string(1, machine.tilt_letter()) + "_dir")
      talk.warn(column + " is not known for this job: effects that depend on it stand at their zero");
  const Range<Angle> stroke =
      machine.tilt().range_angle.value_or(Range<Angle>{Angle::degrees(-360), Angle::degrees(360)});
  const ObservedRanges observed = observed_ranges(model);
  for (auto& [column, value] : job.covariates)
    if (const double end = held(observed, column, value); end != value) {
      talk.warn(column + ": " + formatted("%.6g", value) + " of this job was never observed; held at " +
                formatted("%.6g", end));
      value = end;
    }
  ModelField field(model, job.covariates, stroke);
  std::optional<CompensatedField> rest;
  if (!job.tables.empty())
    rest.emplace(field, chain, play_tables(files_in(job.tables), machine, model));
  else if (file_size(o.input) > kWorthBaking_bytes)
    field.bake(chain);
  const ErrorField& errors = rest ? static_cast<const ErrorField&>(*rest) : field;

  ProgramCorrection how;
  how.dialect = o.dialect.empty() ? told_dialect_of(o.input, machine) : o.dialect;
  how.name = o.input;
  how.threads = o.threads;
  how.guard = guard_of(machine);
  how.guard.tolerance_mm = 1e-3 * o.tolerance_um;
  how.scan = scan_settings(how.dialect, machine, chain, job);
  how.scan.decimals = o.decimals;
  how.scan.keep_going = o.keep_going;
  how.scan.tcp_forced = o.tcp != "auto";
  if (how.scan.tcp_forced) how.scan.tcp = o.tcp == "on";
  how.header = "model " + sha256_hex(model_bytes).substr(0, kHashDigits) + ", machine " + machine.name + ", serial " +
               machine.serial;
  how.keep_insertions = !o.report.empty();

  CorrectionSettings settings;
  settings.orientation =
      o.only_position || o.orientation == "off" ? Orientation::as_programmed : Orientation::corrected;
  settings.largest_rotary_change = machine.limits.rotary_word;
  settings.tool_length_mm = tool_length_mm(job, chain);
  CorrectionSettings without = settings;
  without.tcp = ToolCentrePoint::off;
  const Corrector with_tcp(chain, errors, settings), without_tcp(chain, errors, without);

  std::vector<std::string> inputs = {o.machine, o.model, o.input};
  if (!o.job.empty()) inputs.push_back(o.job);
  OutputFile output(o.output, inputs);
  ProgramCorrectionResult result;
  {
    ProgressLine line(o.input, talk);
    how.progress = [&](std::uint64_t bytes) { line.at(bytes); };
    result = correct_program(
        program_file(o.input), [&](std::string_view text) { output.append(text); }, with_tcp, without_tcp, how);
  }
  for (const Refusal& refusal : result.refusals)
    talk.warn(o.input + ":" + std::to_string(refusal.line) + ": copied uncorrected: " + refusal.reason);

  std::optional<PlaybackResult> played;
  if (!o.report.empty() && result.refusals.empty())
    played = play_back(program_file(o.input), program_file(output.written()), with_tcp, without_tcp, how, result);
  const double room_mm = how.guard.tolerance_mm + kRoundingRoom * std::pow(10.0, -o.decimals);
  nlohmann::json summary = summary_json(o, how, result, played);
  summary["compensated_by"] = job.tables.empty() ? "nothing" : "tables";
  summary["machine"] = {{"name", machine.name}, {"serial", machine.serial}};
  std::vector<std::string> evidence = {o.machine, o.model};  // not the program: it may be a stream, or huge
  if (!o.job.empty()) evidence.push_back(o.job);
  summary.update(provenance_json(evidence));
  if (played && played->after.largest_tip_mm > room_mm && result.counts.beyond_tolerance == 0) {
    write_whole(o.report, json_text(summary), inputs);
    throw RefusalError(o.input + ":" + std::to_string(played->after.tip_line) + ": played back, the tip is still " +
                       formatted("%.3f um", 1e3 * played->after.largest_tip_mm) +
                       " off; nothing was written but the report");
  }
  output.commit();
  if (!o.report.empty()) write_whole(o.report, json_text(summary), inputs);
  if (result.counts.copied_moves > 0)
    talk.warn(std::to_string(result.counts.copied_moves) +
              " blocks move before every axis was programmed (or after G28, G53 or a tool change): copied");
  if (result.counts.beyond_tolerance > 0)
    talk.warn(std::to_string(result.counts.beyond_tolerance) +
              " blocks do not hold the tolerance between their ends, however often divided");
  if (talk.json) std::fputs(json_text(summary).c_str(), stdout);
  talk.show(summary_text(result, played));
  talk.say("wrote " + o.output);
  return result.refusals.empty() ? 0 : 1;
}

}  // namespace

Command correct_command(CLI::App& program, const Talk& talk) {
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("correct", "An NC program with corrected positions and orientations");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--model", o->model, "Model (JSON)")->required()->type_name("model.json")->group("Input");
  app->add_option("--job", o->job, "Job: work offsets, tools, covariates (TOML)")->type_name("J.toml")->group("Input");
  app->add_option("program", o->input, "NC program")->required()->type_name("IN.nc")->group("Input");
  app->add_option("-o,--output", o->output, "Corrected program")->required()->type_name("OUT.nc")->group("Output");
  app->add_option("--report", o->report, "Play the result back and report before and after (JSON)")
      ->type_name("R.json")
      ->group("Output");
  app->add_option("--dialect", o->dialect, "Dialect of the program; default: told by it or by the machine's controller")
      ->check(CLI::IsMember(dialect_names()))
      ->group("Program");
  app->add_option("--tcp", o->tcp,
                  "Tool-centre-point control: X Y Z turn with the table (on) or are machine coordinates (off)")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str()
      ->group("Program");
  app->add_option("--decimals", o->decimals, "Least decimals of corrected words, mm and deg (inches get two more)")
      ->check(CLI::Range(2, 6))
      ->capture_default_str()
      ->group("Program");
  app->add_option("--orientation", o->orientation, "Whether the rotary axes are corrected as well")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str()
      ->group("Correction");
  app->add_flag("--only-position", o->only_position, "The same as --orientation off")->group("Correction");
  app->add_option("--tolerance", o->tolerance_um,
                  "Tip error allowed between end points, um; moves are divided until they hold")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str()
      ->group("Correction");
  app->add_flag("--keep-going", o->keep_going, "Copy blocks that are refused, and list them (exit status 1)")
      ->group("Correction");
  app->add_option("--threads", o->threads, "Threads")
      ->check(CLI::Range(1, 64))
      ->capture_default_str()
      ->group("Correction");
  app->footer(
      "Example:\n  trunnion correct --machine machine.toml --model model.json --job job.toml part.ngc -o "
      "part_corrected.ngc");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
