#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "app/command.h"
#include "app/version.h"
#include "error.h"

namespace trunnion {

void Talk::say(const std::string& line) const {
  if (!quiet) std::fprintf(stderr, "%s\n", line.c_str());
}

void Talk::warn(const std::string& line) const { say("warning: " + line); }

void Talk::show(const std::string& text) const {
  if (!json) std::fwrite(text.data(), 1, text.size(), stdout);
}

namespace {

int report(int status, const std::string& text) {
  std::fprintf(stderr, "trunnion: %s\n", text.c_str());
  return status;
}

int run(int argc, char** argv) {
  CLI::App program("Errors of five-axis machines with a tilting rotary table: identify, correct, verify.", "trunnion");
  program.set_version_flag("--version", std::string("trunnion ") + kVersion);
  program.require_subcommand(1);
  program.footer(
      "trunnion COMMAND --help explains each command.\n"
      "Exit status: 0 done, 1 a check that protects a machine failed, 2 bad usage or bad input.");
  Talk talk;
  std::vector<Command> commands;
  for (const auto& add : {
           identify_command,
           evaluate_command,
           correct_command,
           close_command,
       })
    commands.push_back(add(program, talk));
  for (const Command& command : commands) {
    command.options->add_flag("--json", talk.json, "Print the machine-readable summary on standard output")
        ->group("Talk");
    command.options->add_flag("--quiet", talk.quiet, "Say nothing but errors")->group("Talk");
    command.options->add_flag("--verbose", talk.verbose, "Say more")->group("Talk");
  }
  try {
    program.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return program.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return program.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return program.exit(e);
  } catch (const CLI::ParseError& e) {
    return report(2, std::string(e.what()) + " (see trunnion --help)");
  }
  for (const Command& command : commands)
    if (command.options->parsed()) return command.run();
  return 2;
}

}  // namespace
}  // namespace trunnion

int main(int argc, char** argv) {
  using namespace trunnion;
  try {
    const int status = run(argc, argv);
    if (std::fflush(stdout) != 0) return report(2, "standard output: cannot be written");
    return status;
  } catch (const RangeError& e) {
    return report(1, e.what());
  } catch (const RefusalError& e) {
    return report(1, e.what());
  } catch (const Error& e) {
    return report(2, e.what());
  } catch (const std::bad_alloc&) {
    return report(2, "out of memory");
  } catch (const std::exception& e) {
    return report(2, e.what());
  }
}
