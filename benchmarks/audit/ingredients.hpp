#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace finegauge {

/// A part of the model, or of how it is solved, that a scene may do with or without.
struct Ingredient {
  std::string name;
  std::string about;                   ///< what the change does, in a few words
  bool present = true;                 ///< in the scene: it is left out; else it is added
  std::vector<std::string> overrides;  ///< arguments of --set that make the change
};

/// Those that make sense for the scene: a scene without a needle has none of its ingredients.
std::vector<Ingredient> scene_ingredients(const Scene& scene);

}  // namespace finegauge
