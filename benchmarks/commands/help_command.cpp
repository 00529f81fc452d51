#include <algorithm>
#include <cstdio>
#include <memory>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/program/command.hpp"
#include "core/scene/scene_keys.hpp"

namespace finegauge {

void add_help_command(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("help", "Explains a command, or all keys of a scene file");
  const auto topic = std::make_shared<std::string>();
  command->add_option("TOPIC", *topic, "scene, or a command");
  command->footer("Examples:\n  finegauge help scene\n  finegauge help run");
  command->callback([&program, topic] {
    std::string text;
    if (*topic == "scene") {
      text = scene_help();
    } else if (topic->empty()) {
      // program.help() would be that of the command given, which is this one.
      text = program.get_formatter()->make_help(&program, "finegauge", CLI::AppFormatMode::Normal);
    } else {
      const std::vector<CLI::App*> commands = program.get_subcommands({});
      const auto found =
          std::ranges::find(commands, *topic, [](const CLI::App* candidate) { return candidate->get_name(); });
      if (found == commands.end()) {
        std::string known = "scene";
        for (const CLI::App* one : commands) known.append(", ").append(one->get_name());
        throw UsageError("help: no topic \"" + *topic + "\"; topics are: " + known);
      }
      text = (*found)->help("finegauge");
    }
    std::fputs(text.c_str(), stdout);
  });
}

}  // namespace finegauge
