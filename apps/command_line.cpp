#include "command_line.h"

#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cassert>

#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/options_yaml.h"

namespace cpplus {

namespace {

/// "refine.search.radius_px" -> "search.radius-px": the section of the command is left out, as in the flags.
std::string flag_name(const std::string& path, const std::string& command) {
  const std::string section = command + ".";
  std::string name = path.starts_with(section) ? path.substr(section.size()) : path;
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

/// The heading a flag stands under in --help: the groups around it.
std::string help_group(const std::string& name) {
  const size_t dot = name.rfind('.');
  return dot == std::string::npos ? "Options" : "Options: " + name.substr(0, dot);
}

std::string type_label(const OptionField& field) {
  if (std::holds_alternative<int*>(field.value)) return "INT";
  return std::holds_alternative<double*>(field.value) ? "NUMBER" : "TEXT";
}

/// What CLI11 says of a wrong command line, in words that name what is wrong first.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const auto command = app.get_subcommands();
  const std::string help =
      fmt::format("(see cpplus{} --help)", command.empty() ? "" : " " + command.front()->get_name());
  const std::vector<std::string> extras = app.remaining(true);
  if (extras.empty()) return fmt::format("{} {}", error.what(), help);
  const auto is_option = [](const std::string& extra) { return extra.starts_with("-"); };
  const auto option = std::find_if(extras.begin(), extras.end(), is_option);
  return option == extras.end() ? fmt::format("unexpected argument '{}' {}", extras.front(), help)
                                : fmt::format("unknown option '{}' {}", *option, help);
}

}  // namespace

void GlobalOptions::validate() const { check_option(threads >= 0 && threads <= 1024, "threads", "[0, 1024]", threads); }

CommandLine::CommandLine() : app_("CP+: aligns camera images with a LiDAR map and colours the map.", "cpplus") {
  app_.set_version_flag("--version", CPPLUS_VERSION);
  app_.require_subcommand(1);
  app_.get_formatter()->column_width(44);
  fields_ = list_options(global_);
}

CLI::App* CommandLine::add_command(const std::string& name, const std::string& summary,
                                   std::function<void()> run_command) {
  CLI::App* command = app_.add_subcommand(name, summary);
  command->add_option("--config", config_, "YAML file with options; `cpplus config dump` shows all of them")
      ->type_name("FILE")
      ->group("Global");
  for (const OptionField& field : list_options(global_)) add_flag(command, field);
  commands_.push_back({command, std::move(run_command), {}});
  return command;
}

void CommandLine::add_options(CLI::App* command, const std::vector<OptionField>& fields) {
  for (const OptionField& field : fields) add_flag(command, field);
  fields_.insert(fields_.end(), fields.begin(), fields.end());
  commands_.back().fields = fields;
}

const CommandLine::Command* CommandLine::find(const std::string& name) const {
  const auto is_it = [&](const Command& command) { return command.app->get_name() == name; };
  const auto found = std::find_if(commands_.begin(), commands_.end(), is_it);
  return found == commands_.end() ? nullptr : &*found;
}

bool CommandLine::has_command(const std::string& name) const { return find(name) != nullptr; }

RunStep CommandLine::step(const std::string& name) const {
  const Command* command = find(name);
  assert(command != nullptr);
  return {name, command->fields, command->run};
}

void CommandLine::add_flag(CLI::App* command, const OptionField& field) {
  const bool is_global = field.path.find('.') == std::string::npos;
  const std::string name = flag_name(field.path, command->get_name());
  CLI::Option* option = nullptr;
  if (const auto* flag = std::get_if<bool*>(&field.value)) {
    const auto store = [this, field](const char* text) { return [=, this] { overrides_.emplace_back(field, text); }; };
    const std::string doc = field.doc + (**flag ? " On; --no-" + name + " turns it off." : "");
    // --name=false would be taken and do nothing, were it not refused.
    option = command->add_flag_callback("--" + name, store("true"), doc)->disable_flag_override();
    CLI::Option* off = command->add_flag_callback("--no-" + name, store("false"))->disable_flag_override();
    off->group("");  // an empty group is not shown in --help
  } else {
    const auto store = [this, field](const std::string& text) { overrides_.emplace_back(field, text); };
    option = command->add_option_function<std::string>("--" + name, store, field.doc);
    option->type_name(type_label(field))->default_str(option_text(field));
  }
  option->group(is_global ? "Global" : help_group(name));
}

std::string CommandLine::defaults_yaml() const { return options_to_yaml(fields_); }

int CommandLine::run(int argc, const char* const* argv) {
  const auto is_first_argument = [&](const auto& command) { return command.app->check_name(argv[1]); };
  if (argc > 1 && argv[1][0] != '-' && std::none_of(commands_.begin(), commands_.end(), is_first_argument)) {
    throw UsageError(fmt::format("unknown command '{}' (see cpplus --help)", argv[1]));
  }
  try {
    app_.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app_.exit(error);  // --help and --version
    throw UsageError(usage_message(app_, error));
  }
  if (!config_.empty()) read_options_yaml(config_, fields_);
  const std::string command = app_.get_subcommands().front()->get_name();
  for (const auto& [field, text] : overrides_) set_option(field, "--" + flag_name(field.path, command), text);

  global_.validate();
  set_num_threads(global_.threads);
  set_quiet(global_.quiet);
  set_json_progress(global_.json_progress);
  for (const Command& command_of : commands_) {
    if (command_of.app->parsed()) command_of.run();
  }
  return 0;
}

}  // namespace cpplus
