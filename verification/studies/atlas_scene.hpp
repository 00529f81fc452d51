#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/insertion_frame.hpp"
#include "core/scene/scene.hpp"
#include "core/static_step.hpp"
#include "verification/support/atlas.hpp"

namespace finegauge {

/// Points of the atlas that are scenes: the text is made for the value, read as any scene is, and solved as the program
/// solves it. What is saved is what was run.

/// Each "$NAME" in the text becomes its number, with all its digits.
std::string filled(std::string text, std::span<const std::pair<std::string_view, double>> values);
inline std::string filled(std::string text, std::initializer_list<std::pair<std::string_view, double>> values) {
  return filled(std::move(text), std::span(values.begin(), values.size()));
}

/// Reads the text, with the files that it names beside it. Throws SceneError as read_scene does, without the folder.
Scene scene_from_text(const std::string& text, std::span<const AtlasFile> files = {});

/// A static scene without [adapt], solved. Throws SceneError where the supports do not hold it.
struct StaticEnd {
  Scene scene;
  RefinementForest forest;
  StaticSolution solution;
};
StaticEnd solve_scene(const std::string& text, std::span<const AtlasFile> files = {});
/// Why it is no answer: "did not converge, ..."; empty where it is one.
std::string why_unsolved(const Equilibrium& equilibrium);

/// A frame of a moving scene, and where it led. `insertion`: null without a needle.
struct FrameView {
  const InsertionReport& report;
  const Tissue& tissue;
  const Insertion* insertion;
};
/// All frames, or as many as `observe` is content with (false: enough).
void run_scene(const Scene& scene, const std::function<bool(const FrameView&)>& observe);

/// `judged` of the scene's text: a scene or input that is refused makes the point a refusal, and text and files are
/// part of it whatever happens.
AtlasPoint scene_point(double value, const std::string& text, const std::function<AtlasPoint()>& judged,
                       std::vector<AtlasFile> files = {});

}  // namespace finegauge
