#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>

namespace finegauge {

/// What a key holds. Ranges of lists hold for each entry.
enum class KeyType {
  text,
  choice,  ///< one of the words in `choices`
  boolean,
  integer,
  number,       ///< a whole number is one, too
  integers3,    ///< [i, j, k]
  vector,       ///< [x, y, z]
  direction,    ///< [x, y, z], not all zero
  matrix,       ///< three rows of three numbers
  axes,         ///< some of "x", "y", "z", none twice
  refinement,   ///< a template such as "2x2x2"
  points,       ///< a list of [x, y, z]
  index_list,   ///< a list of whole numbers
  index_lists,  ///< a list of lists of whole numbers
  course        ///< a list of [time, factor], times strictly ascending
};

/// Allowed numbers; the checks are written so that NaN is outside every range.
struct KeyRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_allowed = false, high_allowed = false;
  std::string_view why = {};  ///< reason for a limit that is not obvious

  bool contains(double value) const {
    return (low_allowed ? value >= low : value > low) && (high_allowed ? value <= high : value < high);
  }
};

inline constexpr std::string_view required_key = "required";
inline constexpr std::string_view optional_key = "none";

/// Which scenes a key belongs to: moving ones have the section [dynamics], static ones do not.
enum class KeyScope { always, static_only, moving_only };

/// A row of the table that both validates scenes and explains them.
struct SceneKey {
  std::string_view section;  ///< "" for keys before the first section
  std::string_view key;
  KeyType type;
  std::string_view unit;           ///< "" without one
  KeyRange range;                  ///< of numbers
  std::string_view choices;        ///< words separated by |, of a choice
  std::string_view default_value;  ///< as TOML; or required_key, optional_key
  std::string_view explanation;
  KeyScope scope = KeyScope::always;     ///< elsewhere the key is refused, and required nowhere else
  std::string_view why_not = {};         ///< what a scene of the other kind has in its place
  std::string_view moving_default = {};  ///< where it differs from default_value in a moving scene

  bool applies(bool moving) const { return scope == KeyScope::always || (scope == KeyScope::moving_only) == moving; }
  std::string_view default_in(bool moving) const {
    return moving && !moving_default.empty() ? moving_default : default_value;
  }
};

struct SceneSection {
  std::string_view name;
  bool repeated;  ///< [[name]], any number of times, instead of [name]
  bool required;
  std::string_view explanation;
};

/// All sections and all keys, in the order in which help shows them. A new section is new rows here, and the lines of
/// the scene reader that turn its values into a struct.
std::span<const SceneSection> scene_sections();
std::span<const SceneKey> scene_keys();

const SceneSection* find_section(std::string_view name);
const SceneKey* find_key(std::string_view section, std::string_view key);

/// Type and range of a key in words, such as "a number in (-1, 0.5)".
std::string allowed_values(const SceneKey& key);

/// For a word that is not known: the nearest known one by edit distance, if one is near, and all that are allowed.
std::string suggest_key(std::string_view section, std::string_view word);
std::string suggest_section(std::string_view word);

/// Text of `finegauge help scene`: all keys, then an example.
std::string scene_help();
/// The complete scene at the end of the help.
std::string_view example_scene();

}  // namespace finegauge
