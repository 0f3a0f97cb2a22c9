#include "batch/batch_plan.h"

#include <algorithm>

#include "error.h"

namespace trunnion {
namespace {

/// FNV-1a, 64 bit: a seed that depends on the name alone (http://www.isthe.com/chongo/tech/comp/fnv).
std::uint64_t seed_of(std::uint64_t seed, const std::string& name) {
  std::uint64_t hash = 0xcbf29ce484222325U ^ seed;
  for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3U;
  return hash >> 32U;
}

/// The jobs of one machine, with the indices that they will have after `first`.
class MachineJobs {
 public:
  MachineJobs(const BatchPlan& plan, const BatchMachine& machine, const std::string& folder, std::vector<BatchJob>& all)
      : plan_(plan), machine_(machine), folder_(folder), all_(all) {}

  void add() {
    if (machine_.model.empty()) add_model();
    for (const std::string& controller : plan_.controllers) add_tables(controller);
    for (const BatchProgram& program : plan_.programs) add_program(program);
    for (const BatchPiece& piece : plan_.pieces) {
      if (piece.controllers.empty()) add_piece(piece, "");
      for (const std::string& controller : piece.controllers) add_piece(piece, controller);
    }
  }

 private:
  BatchJob job(JobKind kind, const std::string& label, const std::string& command) const {
    BatchJob job{.kind = kind, .machine = machine_.name, .label = label};
    job.stem = folder_ + "/" + machine_.name + "/" + label;
    job.words = {command, "--machine", machine_.machine_file};
    job.inputs = {machine_.machine_file};
    return job;
  }

  /// A job that reads the machine's model.
  BatchJob job_on_model(JobKind kind, const std::string& label, const std::string& command) const {
    BatchJob made = job(kind, label, command);
    made.words.insert(made.words.end(), {"--model", model_.empty() ? machine_.model : model_});
    if (model_.empty()) {
      made.inputs.push_back(machine_.model);
    } else {
      made.after.push_back(model_index_);
      made.stage = 2;
    }
    return made;
  }

  void add_model() {
    BatchJob made = job(JobKind::identify, "model", "identify");
    model_ = made.result = made.stem + ".json";
    made.words.insert(made.words.end(), {"--observations", machine_.observations, "-o", model_});
    made.inputs.push_back(machine_.observations);
    model_index_ = all_.size();
    all_.push_back(std::move(made));
  }

  void add_tables(const std::string& controller) {
    BatchJob made = job_on_model(JobKind::tables, "tables." + controller, "tables");
    made.result = made.stem + "/verification.json";
    made.words.insert(made.words.end(), {"--controller", controller, "-o", made.stem});
    all_.push_back(std::move(made));
  }

  void add_program(const BatchProgram& program) {
    BatchJob made = job_on_model(JobKind::correct, "program." + program.name, "correct");
    made.result = made.stem + ".json";
    if (!program.job.empty()) {
      made.words.insert(made.words.end(), {"--job", program.job});
      made.inputs.push_back(program.job);
    }
    made.words.insert(made.words.end(), {program.file, "-o", made.stem + ".nc", "--report", made.result});
    made.inputs.push_back(program.file);
    all_.push_back(std::move(made));
  }

  void add_piece(const BatchPiece& piece, const std::string& controller) {
    BatchJob made =
        job_on_model(JobKind::predict, "piece." + piece.name + (controller.empty() ? "" : "." + controller), "predict");
    made.result = made.stem + "/prediction.json";
    made.words.insert(made.words.end(), {"--piece", piece.file, "-o", made.stem});
    made.inputs.push_back(piece.file);
    if (piece.first_order) made.words.emplace_back("--first-order");
    if (piece.corrected) made.words.emplace_back("--corrected");
    made.words.insert(made.words.end(), {"--draws", std::to_string(piece.draws)});
    if (piece.draws > 0)
      made.words.insert(made.words.end(), {"--seed", std::to_string(seed_of(plan_.seed, made.name()))});
    if (!controller.empty()) {
      const auto tables = std::ranges::find_if(all_, [&](const BatchJob& other) {
        return other.machine == machine_.name && other.label == "tables." + controller;
      });
      if (tables == all_.end())
        throw UsageError("piece " + piece.name + ": tables of " + controller +
                         " are asked for, and [tables] makes none");
      made.words.insert(made.words.end(), {"--tables", tables->stem});
      made.after.push_back(static_cast<std::size_t>(tables - all_.begin()));
      made.stage = tables->stage + 1;
    }
    all_.push_back(std::move(made));
  }

  const BatchPlan& plan_;
  const BatchMachine& machine_;
  const std::string& folder_;
  std::vector<BatchJob>& all_;
  std::string model_;  ///< that a job makes; empty where it stands already
  std::size_t model_index_ = 0;
};

}  // namespace

std::vector<BatchJob> batch_jobs(const BatchPlan& plan, const std::string& folder) {
  std::vector<BatchJob> all;
  for (const BatchMachine& machine : plan.machines) MachineJobs(plan, machine, folder, all).add();
  return all;
}

std::string shell_quoted(const std::string& word) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./,:+=@%").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::ranges::all_of(word, plain)) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string job_line(const BatchJob& job, const std::string& program, const std::string& fingerprint) {
  const std::string folder = job.stem.substr(0, job.stem.find_last_of('/'));
  std::string line = "mkdir -p " + shell_quoted(folder) + " && " + shell_quoted(program);
  for (const std::string& word : job.words) line += " " + shell_quoted(word);
  line += " > " + shell_quoted(job.stem + ".txt") + " 2> " + shell_quoted(job.stem + ".log");
  return line + "; s=$?; echo $s " + fingerprint + " > " + shell_quoted(job.stem + ".status") + "; exit $s";
}

}  // namespace trunnion
