#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "batch/batch_plan.h"

namespace trunnion {

/// Told how many jobs are done.
using JobsDone = std::function<void(std::size_t jobs)>;

/// A fingerprint per job: SHA-256 (first 16 digits) of its call, of its input files and of the fingerprints of the jobs
/// it follows. Throws InputError for an input that cannot be read.
std::vector<std::string> fingerprints(const std::vector<BatchJob>& jobs, const JobsDone& progress = {});

/// How a job ended, as its status file tells for this fingerprint: 0 or 1 where it is done; nothing where it has not
/// run, was interrupted, failed, or ran on other inputs.
std::optional<int> job_status(const BatchJob& job, const std::string& fingerprint);

/// Whether a job that ended so is done: with 1 a check failed, which is a result; anything beyond is none.
inline bool is_done(std::optional<int> status) { return status && (*status == 0 || *status == 1); }

/// The results of all jobs that are done, by machine: what each found in a few numbers, and `missing`, the
/// others with what they said. Depends on the plan and the results alone, not on when or in which order they came.
nlohmann::json fleet_json(const BatchPlan& plan, const std::vector<BatchJob>& jobs,
                          const std::vector<std::string>& fingerprints, const JobsDone& progress = {});

/// The same with a row a machine and a column a number.
std::string fleet_csv(const nlohmann::json& fleet);

}  // namespace trunnion
