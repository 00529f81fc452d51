#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/refinement_template.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/scene_keys.hpp"

namespace finegauge {

/// One section of a scene, read by the rows of scene_keys. The constructor refuses unknown keys, keys of the other kind
/// of scene (a moving one has [dynamics]), missing required keys and every value outside its row's type and range, so
/// that the accessors only convert. A key that is not given has its row's default; asking for a key without either is
/// a mistake of the caller.
class SectionReader {
 public:
  /// `field` is the section as messages name it, such as "load[0]"; without a table all keys have their defaults.
  SectionReader(const SceneDocument& document, std::string_view section, std::string field, const toml::table* table);

  bool has(std::string_view key) const { return given(key) != nullptr; }
  /// Whether the section has such a key at all, given or not.
  bool knows(std::string_view key) const { return find_key(section_, key) != nullptr; }

  std::string text(std::string_view key) const;  ///< also of a choice
  bool boolean(std::string_view key) const;
  int integer(std::string_view key) const;
  double number(std::string_view key) const;
  std::array<int, 3> integers3(std::string_view key) const;
  Eigen::Vector3d vector(std::string_view key) const;  ///< also of a direction
  Eigen::Matrix3d matrix(std::string_view key) const;
  std::vector<int> axes(std::string_view key) const;
  RefinementTemplate refinement(std::string_view key) const;
  Eigen::Matrix3Xd points(std::string_view key) const;
  std::vector<int> index_list(std::string_view key) const;
  std::vector<std::vector<int>> index_lists(std::string_view key) const;
  std::vector<std::array<double, 2>> course(std::string_view key) const;

  /// Refuses the key's value, or that it is missing; an `entry` of a list if that is what is wrong.
  [[noreturn]] void refuse(std::string_view key, const std::string& found_and_allowed, int entry = -1) const;
  [[noreturn]] void refuse_missing(std::string_view key, const std::string& why) const;

 private:
  const toml::node* given(std::string_view key) const;
  void check_type(const SceneKey& row) const;
  template <class Convert>
  auto value(std::string_view key, Convert convert) const;

  const SceneDocument* document_;
  std::string_view section_;
  std::string field_;
  const toml::table* table_;
  bool moving_;
};

}  // namespace finegauge
