#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/fleet.h"
#include "app/progress.h"
#include "error.h"
#include "io/batch_file.h"
#include "io/json_text.h"
#include "io/output_file.h"

namespace trunnion {
namespace batch_cli {
namespace {

struct Options {
  std::string plan, output, program = "trunnion";
  bool remaining = false, merge = false;
};

std::string stage_file(int stage) { return "jobs-" + std::to_string(stage) + ".txt"; }

/// Every path in a job's line is one line of text.
void check_words(const Options& o) {
  for (const std::string* word : {&o.plan, &o.output, &o.program})
    if (std::ranges::any_of(*word, [](char c) { return static_cast<unsigned char>(c) < ' '; }))
      throw UsageError("a batch writes a line a job: no line breaks in names, please");
}

int merge(const Options& o, const BatchPlan& plan, const std::vector<BatchJob>& jobs,
          const std::vector<std::string>& prints, const Talk& talk) {
  const nlohmann::json fleet = [&] {
    Progress progress(talk, "gather", static_cast<double>(jobs.size()), "jobs");
    return fleet_json(plan, jobs, prints, [&](std::size_t done) { progress.at(static_cast<double>(done)); });
  }();
  OutputFolder folder(o.output, {o.plan});
  folder.add("fleet.json", json_text(fleet));
  folder.add("fleet.csv", fleet_csv(fleet));
  folder.commit();
  const std::size_t missing = fleet["missing"].size();
  if (talk.json) std::fputs(json_text(fleet).c_str(), stdout);
  talk.show(std::to_string(plan.machines.size()) + " machines, " + std::to_string(jobs.size() - missing) + " of " +
            std::to_string(jobs.size()) + " jobs done\n");
  talk.say("wrote " + o.output + "/fleet.json, fleet.csv");
  if (missing == 0) return 0;
  const std::string first = fleet["missing"][0]["job"], words = fleet["missing"][0]["said"];
  throw RefusalError(o.output + ": " + std::to_string(missing) + " jobs are not done (first: " + first +
                     (words.empty() ? "" : ", which said: " + words) + "); --remaining writes them");
}

int run(const Options& o, const Talk& talk) {
  check_words(o);
  const BatchPlan plan = read_batch_plan(o.plan);
  const std::vector<BatchJob> jobs = batch_jobs(plan, o.output);
  const std::vector<std::string> prints = [&] {
    Progress progress(talk, "read inputs", static_cast<double>(jobs.size()), "jobs");
    return fingerprints(jobs, [&](std::size_t done) { progress.at(static_cast<double>(done)); });
  }();
  if (o.merge) return merge(o, plan, jobs, prints, talk);
  std::map<int, std::string> stages;
  std::map<int, std::size_t> counts;
  nlohmann::json summary = nlohmann::json::array();
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    std::string& text =
        stages[jobs[k].stage];  // an empty file where all of a stage is done: nothing of an earlier plan stays
    if (o.remaining && is_done(job_status(jobs[k], prints[k]))) continue;
    text += job_line(jobs[k], o.program, prints[k]) + "\n";
    ++counts[jobs[k].stage];
    summary.push_back({{"job", jobs[k].name()}, {"stage", jobs[k].stage}, {"result", jobs[k].result}});
  }
  OutputFolder folder(o.output, {o.plan});
  for (const auto& [stage, text] : stages) folder.add(stage_file(stage), text);
  folder.commit();
  if (talk.json) std::fputs(json_text(summary).c_str(), stdout);
  for (const auto& [stage, text] : stages)
    talk.show(o.output + "/" + stage_file(stage) + ": " + std::to_string(counts[stage]) + " jobs" +
              (stage == 1 ? "\n" : ", when all of " + stage_file(stage - 1) + " are done\n"));
  return 0;
}

}  // namespace
}  // namespace batch_cli

Command batch_command(CLI::App& program, const Talk& talk) {
  using namespace batch_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("batch", "Many machines at once: a shell line a job, and the results merged");
  app->add_option("plan", o->plan, "Plan: machines, tables, programs, pieces (TOML)")
      ->required()
      ->type_name("PLAN.toml")
      ->group("Input");
  app->add_option("-o,--output", o->output, "Folder for jobs-1.txt …, and for the results")
      ->required()
      ->type_name("DIR")
      ->group("Output");
  CLI::Option* remaining =
      app->add_flag("--remaining", o->remaining, "Write only jobs that are not done, or not on these inputs")
          ->group("Jobs");
  app->add_flag("--merge", o->merge, "Gather the results in fleet.json and fleet.csv; exit status 1 if any are missing")
      ->excludes(remaining)
      ->group("Jobs");
  app->add_option("--program", o->program, "The program that the lines call")
      ->capture_default_str()
      ->type_name("PATH")
      ->group("Jobs");
  app->footer(
      "Example; lines are run from this folder, a file after the other, the lines of one in any order:\n"
      "  trunnion batch plan.toml -o out\n"
      "  parallel < out/jobs-1.txt; parallel < out/jobs-2.txt\n"
      "  trunnion batch plan.toml -o out --merge\n"
      "On a cluster, as an array of N tasks for a file of N lines:\n"
      "  sbatch --array=1-N --wrap 'sed -n \"${SLURM_ARRAY_TASK_ID}p\" out/jobs-1.txt | sh'");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
