#include <cstdio>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/program/known_scenes.hpp"
#include "benchmarks/program/study.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/studies/evidence_studies.hpp"

namespace finegauge {
namespace {

std::string about_scene(const std::filesystem::path& file) {
  try {
    return read_scene(file).description;
  } catch (const SceneError& error) {
    return std::string("cannot be read: ") + error.what();
  }
}

void print_line(const std::string& name, const std::string& about) {
  std::printf("  %-26s  %s\n", name.c_str(), about.c_str());
}

void print_everything() {
  std::printf("Scenes (finegauge run FILE):\n");
  const std::vector<std::filesystem::path> scenes = known_scenes();
  for (const auto& file : scenes) print_line(file.string(), about_scene(file));
  if (scenes.empty()) std::printf("  none found in reference_data/scenes\n");

  std::printf("\nStudies (finegauge reproduce STUDY):\n");
  for (const Study& study : paper_studies()) print_line(study.name, study.about);

  std::printf("\nEvidence (finegauge verify STUDY):\n");
  for (const EvidenceStudy& study : evidence_studies()) print_line(study.name, study.about);
}

}  // namespace

void add_list_command(CLI::App& program, int&) {
  CLI::App* command = program.add_subcommand("list", "Scenes, studies and evidence, a line each");
  command->footer("Example:\n  finegauge list");
  command->callback(print_everything);
}

}  // namespace finegauge
