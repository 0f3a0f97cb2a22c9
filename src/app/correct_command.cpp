#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/correction_report.h"
#include "app/program_setup.h"
#include "app/progress.h"
#include "app/text_table.h"
#include "error.h"
#include "io/job_file.h"
#include "io/json_text.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/output_file.h"
#include "io/provenance.h"
#include "io/text_file.h"
#include "postproc/dialect.h"
#include "postproc/playback.h"
#include "postproc/program_correction.h"

namespace trunnion {
namespace correct_cli {
namespace {

constexpr double kWorthBaking_bytes = 1e6;  // a bake costs less than correcting this without

struct Options {
  std::string machine, model, job, input, output, dialect, tcp = "auto", orientation = "on", report;
  int decimals = 4, threads = 2;
  double tolerance_um = 0.2;
  bool keep_going = false, only_position = false;
};

/// A file as a source of bytes.
OpenProgram file_source(const std::string& path) {
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

/// A program is read more than once; what is no file (a pipe) is kept.
OpenProgram program_source(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored) || std::filesystem::is_regular_file(path, ignored))
    return file_source(path);
  const auto text = std::make_shared<const std::string>(read_text(path));
  return [text] {
    return [text, at = std::size_t{0}](char* buffer, std::size_t size) mutable {
      const std::size_t taken = text->copy(buffer, size, at);
      at += taken;
      return taken;
    };
  };
}

/// In bytes; 0 for what is no file.
double file_size(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<double>(size);
}

/// `program`, telling how many bytes of it were read.
OpenProgram counted(OpenProgram program, std::function<void(double)> tell) {
  return [program = std::move(program), tell = std::move(tell)] {
    return [read = program(), tell, bytes = 0.0](char* buffer, std::size_t size) mutable {
      const std::size_t taken = read(buffer, size);
      tell(bytes += static_cast<double>(taken));
      return taken;
    };
  };
}

/// The beginning of a program.
std::string head_of(const OpenProgram& program) {
  std::string head(std::size_t{1} << 16, '\0');
  const ReadBytes read = program();
  head.resize(read(head.data(), head.size()));
  return head;
}

void warn_of_what_is_left(const CorrectionCounts& c, const Talk& talk) {
  if (c.copied_moves > 0)
    talk.warn(std::to_string(c.copied_moves) +
              " blocks move before every axis was programmed (or after G28, G53 or a tool change): copied");
  if (c.beyond_tolerance > 0)
    talk.warn(std::to_string(c.beyond_tolerance) +
              " blocks do not hold the tolerance between their ends, however often divided");
  if (c.reversals_left > 0)
    talk.warn("an axis turns round within " + std::to_string(c.reversals_left) +
              " blocks, or before one that cannot be divided: what it loses is not taken up there, " +
              formatted("up to %.2f um", 1e3 * c.largest_reversal_left_mm) + " on line " +
              std::to_string(c.largest_reversal_left_line) + "; post a block's end where the axis turns round");
  if (c.untimed_moves > 0)
    talk.warn("errors of this machine change with the time, and how long " + std::to_string(c.untimed_moves) +
              " moves last is not known (rapids, G95, no F; first: line " + std::to_string(c.first_untimed_line) +
              "): they count as 0 s");
  for (const std::string& text : assumptions_met(c)) talk.warn("not confirmed for this control: " + text);
}

int run(const Options& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  const std::string model_bytes = read_text(o.model, kLargestJson_bytes);
  const Model model = parse_model(model_bytes, o.model, machine);
  check_same_machine(model, machine, o.model);
  for (const std::string& line : changed_inputs(model, o.model, {o.machine})) talk.warn(line);
  Job job;
  if (!o.job.empty())
    job = read_job(o.job);
  else
    talk.warn("no --job: work offsets are zero, and the program's zero is where W has its own");

  if (!job.tables.empty())
    for (const std::string& line : changed_since_verified(job.tables, {o.machine, o.model})) talk.warn(line);
  const OpenProgram program = program_source(o.input);
  const bool orientation = !o.only_position && o.orientation == "on";
  ProgramSetup setup(machine, model, std::move(job),
                     {.dialect = o.dialect,
                      .tcp = o.tcp,
                      .orientation = orientation,
                      .decimals = o.decimals,
                      .threads = o.threads,
                      .tolerance_um = o.tolerance_um,
                      .keep_going = o.keep_going},
                     o.dialect.empty() ? head_of(program) : "", o.input, model_bytes);
  for (const std::string& note : setup.notes()) talk.warn(note);
  if (file_size(o.input) > kWorthBaking_bytes) setup.expect_many_blocks();
  ProgramCorrection& how = setup.how();
  how.keep_insertions = !o.report.empty();

  std::vector<std::string> inputs = {o.machine, o.model, o.input};
  if (!o.job.empty()) inputs.push_back(o.job);
  OutputFile output(o.output, inputs);
  ProgramCorrectionResult result;
  {
    Progress progress(talk, "correct", 1e-6 * file_size(o.input), "MB");
    how.progress = [&](std::uint64_t bytes) { progress.at(1e-6 * static_cast<double>(bytes)); };
    result = correct_program(
        program, [&](std::string_view text) { output.append(text); }, setup.with_tcp(), setup.without_tcp(), how);
  }
  for (const Refusal& refusal : result.refusals)
    talk.warn(o.input + ":" + std::to_string(refusal.line) + ": copied uncorrected: " + refusal.reason);

  std::optional<PlaybackResult> played;
  const bool all_told = result.refusals.size() < kMostRefusals;
  if (!all_told) talk.warn("so many blocks are refused that the result is not played back");
  if (!o.report.empty() && all_told) {
    Progress progress(talk, "play back", 1e-6 * file_size(o.input), "MB");
    played = play_back(counted(program, [&](double bytes) { progress.at(1e-6 * bytes); }),
                       file_source(output.written()), setup.with_tcp(), how, result);
  }
  nlohmann::json summary =
      correction_json(o.input.substr(o.input.find_last_of('/') + 1), orientation, how, result, played);
  summary["compensated_by"] = setup.job().tables.empty() ? "nothing" : "tables";
  summary["machine"] = {{"name", machine.name}, {"serial", machine.serial}};
  std::vector<std::string> evidence = {o.machine, o.model};  // not the program: it may be a stream, or huge
  if (!o.job.empty()) evidence.push_back(o.job);
  summary.update(provenance_json(evidence));
  if (played && !setup.holds(*played) && result.counts.beyond_tolerance == 0) {
    write_whole(o.report, json_text(summary), inputs);
    throw RefusalError(o.input + ":" + std::to_string(played->after.tip_line) + ": played back, the tip is still " +
                       formatted("%.3f um", 1e3 * played->after.largest_tip_mm) +
                       " off; nothing was written but the report");
  }
  output.commit();
  if (!o.report.empty()) write_whole(o.report, json_text(summary), inputs);
  warn_of_what_is_left(result.counts, talk);
  if (talk.json) std::fputs(json_text(summary).c_str(), stdout);
  talk.show(correction_text(result, played) + (talk.verbose && played ? limits_text(*played) : ""));
  talk.say("wrote " + o.output);
  return result.refusals.empty() ? 0 : 1;
}

}  // namespace
}  // namespace correct_cli

Command correct_command(CLI::App& program, const Talk& talk) {
  using namespace correct_cli;
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
