#include <fmt/format.h>

#include "commands.h"

namespace cpplus {

void add_config_command(CommandLine* command_line) {
  const auto dump = [command_line] { fmt::print("{}", command_line->defaults_yaml()); };
  CLI::App* config = command_line->add_command("config", "Shows the options a --config file can hold", dump);
  config->require_subcommand(1);
  config->add_subcommand("dump", "Prints every option of every command at its default, as YAML")->fallthrough();
}

}  // namespace cpplus
