#pragma once

#include "command_line.h"

namespace cpplus {

// One function a command, each in its own cmd_NAME.cpp.
void add_adjust_command(CommandLine* command_line);
void add_clean_command(CommandLine* command_line);
void add_colorize_command(CommandLine* command_line);
void add_evaluate_command(CommandLine* command_line);
void add_export_command(CommandLine* command_line);
void add_import_command(CommandLine* command_line);
void add_poses_command(CommandLine* command_line);
void add_refine_command(CommandLine* command_line);
void add_report_command(CommandLine* command_line);
void add_run_command(CommandLine* command_line);
void add_index_command(CommandLine* command_line);
void add_info_command(CommandLine* command_line);
void add_simulate_command(CommandLine* command_line);
void add_view_command(CommandLine* command_line);
void add_config_command(CommandLine* command_line);

}  // namespace cpplus
