#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.h"

namespace trunnion {
namespace completion_cli {
namespace {

/// An option as a shell sees it.
struct ShellOption {
  std::vector<std::string> names;  ///< "-o", "--output"
  std::string what;                ///< its description
  bool takes_value = false;
  bool takes_folder = false;        ///< a folder and nothing else
  std::vector<std::string> values;  ///< all that it may be; empty: a file or free text
};

/// A command or one of its own commands.
struct ShellCommand {
  std::string path;  ///< "trunnion history add"
  std::string what;
  std::vector<ShellOption> options;
  std::vector<std::string> below;  ///< names of its own commands
};

/// Words of "TEXT:{joint,two-step}", which is how the option tree tells a choice.
std::vector<std::string> choices(const std::string& type_name) {
  std::vector<std::string> words;
  const std::size_t from = type_name.find('{'), to = type_name.find('}');
  if (from == std::string::npos || to == std::string::npos) return words;
  std::string word;
  for (const char c : type_name.substr(from + 1, to - from - 1)) {
    if (c != ',') {
      word += c;
      continue;
    }
    words.push_back(word);
    word.clear();
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

/// Every command of the option tree, those above first.
void walk(const CLI::App& app, const std::string& path, std::vector<ShellCommand>& commands) {
  ShellCommand command{.path = path, .what = app.get_description(), .options = {}, .below = {}};
  for (const CLI::Option* option : app.get_options()) {
    ShellOption shown{.names = {}, .what = option->get_description()};
    for (const std::string& name : option->get_snames()) shown.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) shown.names.push_back("--" + name);
    if (shown.names.empty()) continue;
    shown.takes_value = option->get_items_expected_max() > 0;
    shown.takes_folder = option->get_type_name() == "DIR";
    shown.values = choices(option->get_type_name());
    command.options.push_back(std::move(shown));
  }
  const auto below = app.get_subcommands([](const CLI::App*) { return true; });
  for (const CLI::App* sub : below) command.below.push_back(sub->get_name());
  commands.push_back(std::move(command));
  for (const CLI::App* sub : below) walk(*sub, path + " " + sub->get_name(), commands);
}

/// A word within single quotes.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c == '\n' ? ' ' : c);
  return out + "'";
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

/// Patterns of a shell's `case` for the path of `command` followed by each of `words`.
std::string patterns(const std::string& path, const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : "|") + quoted(path + " " + word);
  return text;
}

/// The branches by which bash and zsh follow the words of a line down the tree.
std::string path_branches(const std::vector<ShellCommand>& commands) {
  std::string text;
  for (const ShellCommand& c : commands)
    if (!c.below.empty()) text += "      " + patterns(c.path, c.below) + ") at=\"$at $word\" ;;\n";
  return text;
}

/// A branch for every option that takes a value, by what `offer` makes of it.
std::string value_branches(const std::vector<ShellCommand>& commands,
                           const std::function<std::string(const ShellOption&)>& offer) {
  std::string text;
  for (const ShellCommand& c : commands)
    for (const ShellOption& o : c.options)
      if (o.takes_value) text += "    " + patterns(c.path, o.names) + ") " + offer(o) + "; return ;;\n";
  return text;
}

std::string bash_script(const std::vector<ShellCommand>& commands) {
  std::string text =
      "# bash completion for trunnion, made by: trunnion completion bash\n"
      "_trunnion() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} at=trunnion word k\n"
      "  COMPREPLY=()\n"
      "  if [ \"$current\" = = ]; then current=; elif [ \"$previous\" = = ]; then "
      "previous=${COMP_WORDS[COMP_CWORD-2]}; fi\n"
      "  for ((k = 1; k < COMP_CWORD; ++k)); do\n    word=${COMP_WORDS[k]}\n    case \"$at $word\" in\n" +
      path_branches(commands) + "    esac\n  done\n  case \"$at $previous\" in\n" +
      value_branches(commands,
                     [](const ShellOption& o) {
                       if (!o.values.empty())
                         return "COMPREPLY=($(compgen -W " + quoted(joined(o.values, " ")) + " -- \"$current\"))";
                       return std::string(o.takes_folder
                                              ? "compopt -o filenames; COMPREPLY=($(compgen -d -- \"$current\"))"
                                              : "compopt -o filenames; COMPREPLY=($(compgen -f -- \"$current\"))");
                     }) +
      "  esac\n  local words=\n  case $at in\n";
  for (const ShellCommand& c : commands) {
    std::vector<std::string> words = c.below;
    for (const ShellOption& o : c.options) words.insert(words.end(), o.names.begin(), o.names.end());
    text += "    " + quoted(c.path) + ") words=" + quoted(joined(words, " ")) + " ;;\n";
  }
  return text +
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  if [ ${#COMPREPLY[@]} -eq 0 ]; then compopt -o filenames; COMPREPLY=($(compgen -f -- \"$current\")); fi\n"
         "}\n"
         "complete -F _trunnion trunnion\n";
}

std::string zsh_script(const std::vector<ShellCommand>& commands) {
  std::string text =
      "#compdef trunnion\n"
      "# zsh completion for trunnion, made by: trunnion completion zsh\n"
      "_trunnion() {\n"
      "  local at=trunnion word previous=${words[CURRENT-1]}\n"
      "  local -a below options\n"
      "  for word in ${words[2,CURRENT-1]}; do\n    case \"$at $word\" in\n" +
      path_branches(commands) + "    esac\n  done\n  case \"$at $previous\" in\n" +
      value_branches(commands,
                     [](const ShellOption& o) {
                       return !o.values.empty() ? "compadd -- " + joined(o.values, " ")
                                                : std::string(o.takes_folder ? "_files -/" : "_files");
                     }) +
      "  esac\n  case $at in\n";
  const auto described = [](std::string name, const std::string& what) {
    for (std::size_t i = name.find(':'); i != std::string::npos; i = name.find(':', i + 2)) name.insert(i, "\\");
    return quoted(name + ":" + what);
  };
  for (const ShellCommand& c : commands) {
    text += "    " + quoted(c.path) + ")\n      below=(";
    for (const ShellCommand& sub : commands)
      for (const std::string& name : c.below)
        if (sub.path == c.path + " " + name) text += " " + described(name, sub.what);
    text += " )\n      options=(";
    for (const ShellOption& o : c.options)
      for (const std::string& name : o.names) text += "\n        " + described(name, o.what);
    text += " ) ;;\n";
  }
  return text +
         "  esac\n"
         "  if [[ $PREFIX == -* ]]; then _describe -o option options\n"
         "  elif (( $#below )); then _describe command below\n"
         "  else _files; fi\n"
         "}\n"
         "if [ \"$funcstack[1]\" = _trunnion ]; then _trunnion \"$@\"; else compdef _trunnion trunnion; fi\n";
}

std::string fish_script(const std::vector<ShellCommand>& commands) {
  std::string text = "# fish completion for trunnion, made by: trunnion completion fish\n";
  for (const ShellCommand& c : commands) {
    // "trunnion history add" is where both words have been seen; its own commands come before one of them is.
    std::string seen;
    for (std::size_t from = c.path.find(' '); from != std::string::npos;) {
      const std::size_t to = c.path.find(' ', from + 1);
      seen += (seen.empty() ? "" : "; and ") + std::string("__fish_seen_subcommand_from ") +
              c.path.substr(from + 1, to == std::string::npos ? to : to - from - 1);
      from = to;
    }
    const std::string top = seen.empty() ? "__fish_use_subcommand" : seen;
    for (const ShellCommand& sub : commands)
      for (const std::string& name : c.below)
        if (sub.path == c.path + " " + name)
          text += "complete -c trunnion -n " +
                  quoted(seen.empty() ? top : seen + "; and not __fish_seen_subcommand_from " + joined(c.below, " ")) +
                  " -f -a " + quoted(name) + " -d " + quoted(sub.what) + "\n";
    for (const ShellOption& o : c.options) {
      text += "complete -c trunnion -n " + quoted(top);
      for (const std::string& name : o.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (o.takes_value) text += o.values.empty() ? " -r" : " -x -a " + quoted(joined(o.values, " "));
      text += " -d " + quoted(o.what) + "\n";
    }
  }
  return text;
}

}  // namespace
}  // namespace completion_cli

Command completion_command(CLI::App& program, const Talk& talk) {
  using namespace completion_cli;
  auto shell = std::make_shared<std::string>();
  CLI::App* app = program.add_subcommand("completion", "The script by which a shell completes trunnion's words");
  app->add_option("shell", *shell, "The shell")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  app->footer(
      "Examples:\n  trunnion completion bash > ~/.local/share/bash-completion/completions/trunnion\n"
      "  trunnion completion zsh > \"${fpath[1]}/_trunnion\"\n"
      "  trunnion completion fish > ~/.config/fish/completions/trunnion.fish");
  return {app, [shell, &program, &talk] {
            std::vector<ShellCommand> commands;
            walk(program, "trunnion", commands);
            const std::string script = *shell == "bash"  ? bash_script(commands)
                                       : *shell == "zsh" ? zsh_script(commands)
                                                         : fish_script(commands);
            talk.show(script);
            if (talk.json) std::printf("%s\n", nlohmann::json({{"shell", *shell}, {"script", script}}).dump(1).c_str());
            return 0;
          }};
}

}  // namespace trunnion
