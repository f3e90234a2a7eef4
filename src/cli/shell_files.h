/// \file
/// What an installed simgap gives to shells: man pages, and completion for bash, zsh and fish, all from the commands
/// and options as CLI11 holds them.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>

namespace simgap {

/// The hidden option with which the build calls the program: `simgap --write-shell-files DIR`.
inline constexpr const char* kWriteShellFiles = "--write-shell-files";

/// Writes man/man1/simgap.1 and simgap-COMMAND.1, bash-completion/completions/simgap, zsh/vendor-completions/_simgap
/// and fish/vendor_completions.d/simgap.fish below a folder. \throws ConfigError: cannot be written.
void writeShellFiles(const CLI::App& app, const std::filesystem::path& folder);

}  // namespace simgap
