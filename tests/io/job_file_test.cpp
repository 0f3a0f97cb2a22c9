#include "io/job_file.h"

#include <gtest/gtest.h>

#include "error.h"

namespace trunnion {
namespace {

TEST(JobFile, GivesOffsetsToolsAndCovariates) {
  const Job job = parse_job(
      "[work_offsets_mm]\nG54 = [1, -2.5, 3]\n\"G59.1\" = [0, 0, 1]\n[tools]\nT1 = {length_mm = 120, diameter_mm = "
      "10}\nT12 = "
      "{length_mm = 80}\n[covariates]\nload_kg = 12.5\n",
      "job.toml");
  EXPECT_EQ(job.work_offsets_mm.at("G54"), (std::array<double, 3>{1, -2.5, 3}));
  EXPECT_EQ(job.work_offsets_mm.at("G59.1"), (std::array<double, 3>{0, 0, 1}));
  EXPECT_EQ(job.tools.at(1), (JobTool{120, 10}));
  EXPECT_EQ(job.tools.at(12), (JobTool{80, 0}));
  EXPECT_EQ(job.covariates.at("load_kg"), 12.5);
  EXPECT_EQ(parse_job("", "job.toml"), Job{});
  EXPECT_EQ(parse_job("format = \"trunnion-job\"\nversion = 1\n", "job.toml"), Job{});
}

TEST(JobFile, RefusesWhatItDoesNotKnow) {
  const std::pair<const char*, const char*> refused[] = {
      {"[work_offset_mm]\nG54 = [1, 2, 3]\n", "work_offsets_mm"},
      {"[work_offsets_mm]\nG53 = [1, 2, 3]\n", "job.toml:2: work_offsets_mm.G53: no work offset"},
      {"[work_offsets_mm]\nG54 = [1, 2]\n", "job.toml:2: work_offsets_mm.G54: "},
      {"[work_offsets_mm]\nG54 = [1, 2, nan]\n", "job.toml:2: work_offsets_mm.G54: "},
      {"[work_offsets_mm]\nG54 = [1, 2, 1e9]\n", "job.toml:2: work_offsets_mm.G54: offsets from -100000 to 100000 mm"},
      {"work_offsets_mm = 3\n", "job.toml:1: work_offsets_mm: "},
      {"[tools]\nX1 = {length_mm = 1}\n", "job.toml:2: tools.X1: no tool"},
      {"[tools]\nT1 = {length = 1}\n", "length_mm"},
      {"[tools]\nT1 = {length_mm = -1}\n", "job.toml:2: tools.T1.length_mm: a length from 0"},
      {"[tools]\nT1 = 7\n", "job.toml:2: tools.T1: "},
      {"[covariates]\nload_kg = \"heavy\"\n", "job.toml:2: covariates.load_kg: "},
      {"format = \"trunnion-piece\"\nversion = 1\n", "trunnion-job"},
      {"[tools\n", "job.toml:"},
  };
  for (const auto& [text, message] : refused) try {
      parse_job(text, "job.toml");
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace trunnion
