#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cpplus/core/option_list.h"
#include "cpplus/pipeline/run_steps.h"

namespace cpplus {

/// Options that every command has; keys at the top level of the configuration file.
struct GlobalOptions {
  int threads = 0;
  bool quiet = false;
  bool json_progress = false;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("threads", threads, "How many threads to use; 0 = all cores. [0, 1024]");
    visitor("quiet", quiet, "Print nothing but warnings, errors and what was asked for.");
    visitor("json_progress", json_progress, "Write progress to stderr as lines of JSON, for other programs.");
  }
};

/// The subcommands of the program. Each field of a command's options is a flag (--group.field-name, --no-... for false)
/// and a key of the YAML file given with --config, inside the section of the command's name. A flag wins over the file.
class CommandLine {
 public:
  CommandLine();

  /// A command without options of its own, so far: the caller may add positional arguments to what is returned.
  CLI::App* add_command(const std::string& name, const std::string& summary, std::function<void()> run_command);

  /// A command that runs on options merged from defaults, file and flags, once they are valid. As above for positional
  /// arguments.
  template <typename Options>
  CLI::App* add_command(const std::string& name, const std::string& summary,
                        std::function<void(const Options&)> run_command) {
    const auto options = std::make_shared<Options>();
    CLI::App* command = add_command(name, summary, [options, run_command] {
      options->validate();
      run_command(*options);
    });
    add_options(command, list_options(*options, name));
    return command;
  }

  bool has_command(const std::string& name) const;
  /// A command with its options, as they are once the command line is parsed, to be run as a part of another.
  RunStep step(const std::string& name) const;
  /// The file given with --config; "" = none.
  const std::string& config() const { return config_; }

  /// Every option of every command at its default, as YAML with comments.
  std::string defaults_yaml() const;

  /// Parses and runs; returns the exit code. Throws UsageError for a command line that is wrong, and what the command
  /// throws.
  int run(int argc, const char* const* argv);

 private:
  void add_options(CLI::App* command, const std::vector<OptionField>& fields);
  void add_flag(CLI::App* command, const OptionField& field);

  CLI::App app_;
  GlobalOptions global_;
  std::string config_;
  std::vector<OptionField> fields_;
  std::vector<std::pair<OptionField, std::string>> overrides_;  // what the flags gave, in their order
  struct Command {
    CLI::App* app = nullptr;
    std::function<void()> run;
    std::vector<OptionField> fields;
  };
  const Command* find(const std::string& name) const;
  std::vector<Command> commands_;
};

}  // namespace cpplus
