#include "shell_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "help.h"
#include "simgap/core/run_directory.h"
#include "simgap/version.h"

namespace simgap {
namespace {

std::vector<const CLI::App*> commandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// "--output", "-o"; none for a positional.
std::vector<std::string> namesOf(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  return names;
}

bool takesValue(const CLI::Option& option) { return option.get_type_size() != 0; }

/// "{bullet,equilibrium}" -> bullet, equilibrium; none for other values.
std::vector<std::string> choicesOf(const CLI::Option& option) {
  const std::string text = valueText(option);
  std::vector<std::string> choices;
  if (!text.starts_with('{') || !text.ends_with('}')) return choices;
  return CLI::detail::split(text.substr(1, text.size() - 2), ',');
}

std::string replacedAll(std::string text, const std::string& from, const std::string& to) {
  return CLI::detail::find_and_replace(std::move(text), from, to);
}

// ------------------------------------------------------------------------------------------------------- man

/// A text that roff takes literally.
std::string roff(const std::string& text) {
  std::string plain = replacedAll(replacedAll(text, "\\", "\\e"), "-", "\\-");
  std::string result;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const bool begins_line = i == 0 || plain[i - 1] == '\n';
    if (begins_line && (plain[i] == '.' || plain[i] == '\'')) result += "\\&";
    result += plain[i];
  }
  return result;
}

std::string manOption(const CLI::Option& option) {
  std::string name =
      option.get_positional() ? option.get_name(true, false) : fmt::format("{}", fmt::join(namesOf(option), ", "));
  const std::string value = valueText(option);
  const bool named = !option.get_positional();
  return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(name),
                     named && !value.empty() ? " \\fI" + roff(value) + "\\fR" : "",
                     roff(option.get_description() + (option.get_required() ? " (required)" : "")));
}

std::string manPage(const CLI::App& command, const std::string& title) {
  std::string text = fmt::format(".TH {} 1 \"\" \"simgap {}\" \"simgap\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
                                 roff(title), kVersion, roff(title), roff(command.get_description()));
  const bool top = title == "simgap";
  std::string arguments, options;
  for (const CLI::Option* option : shownOptions(command)) {
    if (option->get_positional()) {
      const std::string name = option->get_name(true, false);
      arguments += " " + (option->get_required() ? name : "[" + name + "]");
    }
    options += manOption(*option);
  }
  text += fmt::format("\\fBsimgap\\fR {} [options]{}\n", top ? "COMMAND" : roff(command.get_name()), roff(arguments));
  if (top) {
    text += ".SH COMMANDS\n";
    for (const CLI::App* sub : commandsOf(command)) {
      text += fmt::format(".TP\n\\fBsimgap\\-{}\\fR(1)\n{}\n", roff(sub->get_name()), roff(sub->get_description()));
    }
  }
  text += ".SH OPTIONS\n" + options;
  text +=
      ".SH EXIT STATUS\n0 done, 1 a criterion failed, 2 usage, 3 wrong data, 4 the numerics failed, 70 a bug, 130 "
      "interrupted.\n";
  const std::string footer = command.get_footer();
  const std::size_t example = footer.find(":\n");
  if (!top && example != std::string::npos)
    text += ".SH EXAMPLES\n.nf\n" + roff(footer.substr(example + 2)) + "\n.fi\n";
  return text + (top ? "" : ".SH SEE ALSO\nsimgap(1)\n");
}

// ------------------------------------------------------------------------------------------------ completion

std::string bashCompletion(const CLI::App& app) {
  std::string cases, values, commands;
  for (const CLI::App* command : commandsOf(app)) {
    commands += " " + command->get_name();
    std::string words;
    for (const CLI::Option* option : shownOptions(*command)) {
      for (const std::string& name : namesOf(*option)) words += " " + name;
      const std::vector<std::string> choices = choicesOf(*option);
      if (choices.empty() || option->get_positional()) continue;
      values +=
          fmt::format("    {}:{}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n", command->get_name(),
                      fmt::join(namesOf(*option), fmt::format("|{}:", command->get_name())), fmt::join(choices, " "));
    }
    cases += fmt::format("    {}) options='{}' ;;\n", command->get_name(), words.substr(words.empty() ? 0 : 1));
  }
  return fmt::format(R"(# bash completion of simgap; written from its commands
_simgap() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}} options=
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '{} --help --version' -- "$word"))
    return
  fi
  case $command:$before in
{}  esac
  case $command in
{}  esac
  case $word in
    -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
    *) COMPREPLY=() ;;
  esac
}}
complete -o default -F _simgap simgap
)",
                     commands.substr(1), values, cases);
}

/// A text between single quotes of zsh's _arguments, or of fish.
std::string quoted(const std::string& text) { return replacedAll(text, "'", "’"); }

std::string zshSpec(const CLI::Option& option) {
  const std::string description = replacedAll(replacedAll(quoted(option.get_description()), "[", "("), "]", ")");
  const std::vector<std::string> choices = choicesOf(option);
  const std::string value = !takesValue(option) ? ""
                            : choices.empty()   ? ":value:_files"
                                                : fmt::format(":value:({})", fmt::join(choices, " "));
  std::string specs;
  for (const std::string& name : namesOf(option)) {
    specs += fmt::format(" \\\n        '*{}[{}]{}'", name, replacedAll(description, ":", "\\:"), value);
  }
  return specs;
}

std::string zshCompletion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* command : commandsOf(app)) {
    commands += fmt::format("    '{}:{}'\n", command->get_name(), quoted(command->get_description()));
    std::string specs;
    for (const CLI::Option* option : shownOptions(*command)) {
      if (!option->get_positional()) specs += zshSpec(*option);
    }
    cases += fmt::format("    {})\n      _arguments{} \\\n        '*:file:_files' ;;\n", command->get_name(), specs);
  }
  return fmt::format(R"(#compdef simgap
# zsh completion of simgap; written from its commands
_simgap() {{
  local -a commands=(
{}  )
  if (( CURRENT == 2 )); then
    _describe command commands
    return
  fi
  local command=$words[2]
  shift words
  (( CURRENT-- ))
  case $command in
{}  esac
}}
_simgap "$@"
)",
                     commands, cases);
}

std::string fishCompletion(const CLI::App& app) {
  std::string text = "# fish completion of simgap; written from its commands\n";
  for (const CLI::App* command : commandsOf(app)) {
    text += fmt::format("complete -c simgap -n __fish_use_subcommand -f -a {} -d '{}'\n", command->get_name(),
                        quoted(command->get_description()));
    for (const CLI::Option* option : shownOptions(*command)) {
      if (option->get_positional()) continue;
      text += fmt::format("complete -c simgap -n '__fish_seen_subcommand_from {}'", command->get_name());
      for (const std::string& name : option->get_lnames()) text += " -l " + name;
      for (const std::string& name : option->get_snames()) text += " -s " + name;
      const std::vector<std::string> choices = choicesOf(*option);
      if (takesValue(*option)) text += choices.empty() ? " -r" : fmt::format(" -x -a '{}'", fmt::join(choices, " "));
      text += fmt::format(" -d '{}'\n", quoted(option->get_description()));
    }
  }
  return text;
}

}  // namespace

void writeShellFiles(const CLI::App& app, const std::filesystem::path& folder) {
  const auto write = [&](const std::filesystem::path& name, const std::string& text) {
    std::filesystem::create_directories((folder / name).parent_path());
    writeFileAtomically(folder / name, text);
  };
  write("man/man1/simgap.1", manPage(app, "simgap"));
  for (const CLI::App* command : commandsOf(app)) {
    const std::string title = "simgap-" + command->get_name();
    write("man/man1/" + title + ".1", manPage(*command, title));
  }
  write("bash-completion/completions/simgap", bashCompletion(app));
  write("zsh/vendor-completions/_simgap", zshCompletion(app));
  write("fish/vendor_completions.d/simgap.fish", fishCompletion(app));
}

}  // namespace simgap
