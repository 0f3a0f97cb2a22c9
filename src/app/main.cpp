#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <span>

#include "app/command.h"
#include "app/help_format.h"
#include "error.h"
#include "io/provenance.h"
#include "units/nearest_name.h"

namespace trunnion {

namespace {

/// A message stays one line of bearable length, whatever file names and fields it repeats.
std::string one_line(const std::string& text) {
  constexpr std::size_t kLongest = 500, kBegin = 350, kEnd = 140;
  std::string line;
  for (const char c :
       text.size() <= kLongest ? text : text.substr(0, kBegin) + " ... " + text.substr(text.size() - kEnd))
    if (c == '\n')
      line += "\\n";
    else
      line += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return line;
}

}  // namespace

void Talk::say(const std::string& line) const {
  if (!quiet) std::fprintf(stderr, "%s\n", one_line(line).c_str());
}

void Talk::warn(const std::string& line) const { say("warning: " + line); }

void Talk::show(const std::string& text) const {
  if (!json) std::fwrite(text.data(), 1, text.size(), stdout);
}

namespace {

int report(int status, const std::string& text) {
  std::fprintf(stderr, "trunnion: %s\n", one_line(text).c_str());
  return status;
}

using CommandWords = std::span<const std::string>;

/// What is wrong with a command line that CLI11 refused: a misspelled word before whatever it made missing. `words` are
/// those after `app`'s own name, `name`.
std::string usage_text(const CLI::App& app, const std::string& name, const CLI::ParseError& error, CommandWords words) {
  const std::string help = " (see " + name + " --help)";
  const auto nearest = [](const std::string& word, const std::vector<std::string>& known) {
    return "\"" + word + "\" found, the nearest that exists is " + nearest_name(word, known);
  };
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command->get_name());
  if (!commands.empty()) {
    if (words.empty()) return "a command is wanted" + help;
    for (const CLI::App* command : app.get_subcommands())
      return usage_text(*command, name + " " + command->get_name(), error, words.subspan(1));
    if (words[0][0] != '-') return "command: " + nearest(words[0], commands) + help;
  }
  std::vector<std::string> options;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& option_name : option->get_lnames()) options.push_back("--" + option_name);
  for (const std::string& word : app.remaining())
    if (word.starts_with("--")) return nearest(word.substr(0, word.find('=')), options) + help;
  std::string text = error.what();
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text + help;
}

/// The options that say how a command talks, for the command or each of its own commands.
void add_talk(CLI::App& app, Talk& talk) {
  const auto below = app.get_subcommands([](const CLI::App*) { return true; });
  for (CLI::App* command : below) add_talk(*command, talk);
  if (!below.empty()) return;
  app.add_flag("--json", talk.json, "Print the machine-readable summary on standard output")->group("Talk");
  app.add_flag("--quiet", talk.quiet, "Say nothing but errors")->group("Talk");
  app.add_flag("--verbose", talk.verbose, "Say more")->group("Talk");
}

int run(int argc, char** argv) {
  CLI::App program("Errors of five-axis machines with a tilting rotary table: identify, correct, verify.", "trunnion");
  set_help_format(program);
  program.set_version_flag("--version", program_version());
  program.require_subcommand(1);
  program.footer(
      "trunnion COMMAND --help explains each command.\n"
      "Examples:\n  trunnion identify --machine machine.toml --observations calibration.csv -o model.json\n"
      "  trunnion correct --machine machine.toml --model model.json part.ngc -o part_corrected.ngc\n"
      "Exit status: 0 done, 1 a check that protects a machine failed, 2 bad usage or bad input.");
  Talk talk;
  std::vector<Command> commands;
  struct Entry {
    const char* group;
    Command (*add)(CLI::App&, const Talk&);
  };
  constexpr const char *kMeasure = "Measure and understand", *kCorrect = "Correct", *kKeep = "Keep and show";
  for (const auto& [group, add] : std::initializer_list<Entry>{
           {kMeasure, doctor_command},
           {kMeasure, identify_command},
           {kMeasure, close_command},
           {kMeasure, plan_command},
           {kMeasure, import_command},
           {kMeasure, evaluate_command},
           {kCorrect, tables_command},
           {kCorrect, correct_command},
           {kCorrect, predict_command},
           {kKeep, report_command},
           {kKeep, history_command},
           {kKeep, batch_command},
           {kKeep, completion_command},
       }) {
    commands.push_back(add(program, talk));
    commands.back().options->group(group);
  }
  for (const Command& command : commands) add_talk(*command.options, talk);
  try {
    program.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return program.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return program.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return program.exit(e);
  } catch (const CLI::ParseError& e) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    return report(2, usage_text(program, "trunnion", e, words));
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
