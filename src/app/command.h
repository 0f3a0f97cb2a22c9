#pragma once

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace trunnion {

/// What every command shares: how it talks.
struct Talk {
  bool json = false;   ///< the machine-readable summary on standard output
  bool quiet = false;  ///< nothing but errors on standard error
  bool verbose = false;

  /// A line of talk on standard error, unless quiet.
  void say(const std::string& line) const;
  /// A warning that says what to do, on standard error, unless quiet.
  void warn(const std::string& line) const;
  /// Text that the user asked for, on standard output; nothing with --json.
  void show(const std::string& text) const;
};

/// The exit status that a command ends with; most end with 0 or by an exception.
using Run = std::function<int()>;

/// Every command adds its sub-command to the option tree and returns what to run when it was chosen.
struct Command {
  CLI::App* options = nullptr;
  Run run;
};
Command doctor_command(CLI::App& program, const Talk& talk);
Command identify_command(CLI::App& program, const Talk& talk);
Command evaluate_command(CLI::App& program, const Talk& talk);
Command tables_command(CLI::App& program, const Talk& talk);
Command predict_command(CLI::App& program, const Talk& talk);
Command correct_command(CLI::App& program, const Talk& talk);
Command close_command(CLI::App& program, const Talk& talk);
Command plan_command(CLI::App& program, const Talk& talk);
Command import_command(CLI::App& program, const Talk& talk);
Command history_command(CLI::App& program, const Talk& talk);
Command batch_command(CLI::App& program, const Talk& talk);
Command report_command(CLI::App& program, const Talk& talk);
Command completion_command(CLI::App& program, const Talk& talk);

}  // namespace trunnion
