#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>

namespace trunnion {

/// A tool as the job tells it.
struct JobTool {
  double length_mm = 0;
  double diameter_mm = 0;
  friend bool operator==(const JobTool&, const JobTool&) = default;
};

/// What a program is run with (CONTRACT: Job).
struct Job {
  std::map<std::string, std::array<double, 3>> work_offsets_mm;  ///< by code: "G54"
  std::map<int, JobTool> tools;                                  ///< by number: T1
  std::map<std::string, double> covariates;                      ///< for effects that need them
  std::string tables;  ///< folder of the tables that the control plays already; empty: none
  friend bool operator==(const Job&, const Job&) = default;
};

/// A job file (TOML). Every key is checked; throws InputError with file and line, what was found and what is wanted.
Job read_job(const std::string& path);
/// The same from text; `name` stands for the file in messages.
Job parse_job(std::string_view text, const std::string& name);

}  // namespace trunnion
