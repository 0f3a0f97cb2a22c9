#include "batch/batch_plan.h"

#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <set>

#include "error.h"

namespace trunnion {
namespace {

BatchPlan plan() {
  return {.seed = 7,
          .machines = {{.name = "m1", .machine_file = "f/m1/machine.toml", .observations = "f/m1/observations.csv"},
                       {.name = "m2", .machine_file = "f/m2/machine.toml", .model = "f/m2/model.json"}},
          .controllers = {"linuxcnc", "fanuc-30i"},
          .programs = {{.name = "blade", .file = "blade.nc", .job = "job.toml"}},
          .pieces = {{.name = "cone", .file = "cone.toml", .draws = 50},
                     {.name = "under", .file = "cone.toml", .controllers = {"fanuc-30i"}}}};
}

const BatchJob& job_named(const std::vector<BatchJob>& jobs, const std::string& name) {
  return *std::ranges::find_if(jobs, [&](const BatchJob& job) { return job.name() == name; });
}

TEST(BatchPlan, MakesAJobOfEachTaskForEachMachine) {
  const std::vector<BatchJob> jobs = batch_jobs(plan(), "out");
  std::set<std::string> names, stems;
  for (const BatchJob& job : jobs) names.insert(job.name()), stems.insert(job.stem);
  EXPECT_EQ(jobs.size(), 11U);  // six for m1, five for m2, whose model stands already
  EXPECT_EQ(names.size(), jobs.size());
  EXPECT_EQ(stems.size(), jobs.size());
  EXPECT_THAT(job_named(jobs, "m1.model").words,
              ::testing::ElementsAre("identify", "--machine", "f/m1/machine.toml", "--observations",
                                     "f/m1/observations.csv", "-o", "out/m1/model.json"));
  EXPECT_THAT(job_named(jobs, "m2.program.blade").words,
              ::testing::ElementsAre("correct", "--machine", "f/m2/machine.toml", "--model", "f/m2/model.json", "--job",
                                     "job.toml", "blade.nc", "-o", "out/m2/program.blade.nc", "--report",
                                     "out/m2/program.blade.json"));
}

TEST(BatchPlan, PutsAJobInALaterStageThanWhatItReads) {
  const std::vector<BatchJob> jobs = batch_jobs(plan(), "out");
  for (const BatchJob& job : jobs)
    for (const std::size_t earlier : job.after) EXPECT_LT(jobs[earlier].stage, job.stage) << job.name();
  EXPECT_EQ(job_named(jobs, "m1.piece.under.fanuc-30i").stage, 3);
  EXPECT_EQ(job_named(jobs, "m2.tables.linuxcnc").stage, 1);
}

TEST(BatchPlan, GivesAMachineTheSameJobsWhateverElseIsInTheFleet) {
  BatchPlan alone = plan();
  alone.machines.erase(alone.machines.begin());
  const std::vector<BatchJob> all = batch_jobs(plan(), "out"), few = batch_jobs(alone, "out");
  for (const BatchJob& job : few) EXPECT_EQ(job.words, job_named(all, job.name()).words);
}

TEST(BatchPlan, GivesEachPredictionASeedOfItsOwn) {
  const std::vector<BatchJob> jobs = batch_jobs(plan(), "out");
  const auto seed = [&](const std::string& name) {
    const std::vector<std::string>& words = job_named(jobs, name).words;
    return *std::next(std::ranges::find(words, "--seed"));
  };
  EXPECT_NE(seed("m1.piece.cone"), seed("m2.piece.cone"));
  BatchPlan other = plan();
  other.seed = 8;
  EXPECT_NE(job_named(batch_jobs(other, "out"), "m1.piece.cone").words, job_named(jobs, "m1.piece.cone").words);
}

TEST(BatchPlan, RefusesAPieceUnderTablesThatNobodyMakes) {
  BatchPlan wrong = plan();
  wrong.pieces[1].controllers = {"aerotech"};
  EXPECT_THROW(batch_jobs(wrong, "out"), UsageError);
}

/// What a real shell makes of a line.
std::string shell(const std::string& line) {
  std::FILE* pipe = ::popen(line.c_str(), "r");
  std::string text;
  std::array<char, 256> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) text.append(buffer.data(), n);
  return ::pclose(pipe) == 0 ? text : "the shell failed";
}

TEST(ShellQuoted, ComesBackFromAShellAsItWas) {
  for (const std::string word :
       {"plain-1.2_/x:y,z+=@%", "two words", "it's", "\"quoted\"", "$HOME `ls` $(ls) \\ ! # & ; | > < * ? [a] {b} ~",
        "", "Prüfstück", "-n", "'", "''", "a'b'c"})
    EXPECT_EQ(shell("printf %s " + shell_quoted(word)), word);
}

TEST(JobLine, NotesHowTheJobEndedAndEndsSo) {
  BatchJob job{
      .machine = "m", .label = "x", .stem = ::testing::TempDir() + "/it's a batch/m/x", .words = {"-c", "exit 3"}};
  const std::string line = job_line(job, "sh", "f00d");
  EXPECT_EQ(line.find('\n'), std::string::npos);
  EXPECT_EQ(shell("(" + line + "); echo ended $?"), "ended 3\n");
  EXPECT_EQ(shell("cat " + shell_quoted(job.stem + ".status")), "3 f00d\n");
}

}  // namespace
}  // namespace trunnion
