#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace finegauge {
/// Throws std::runtime_error.
[[noreturn]] void refuse_unparsable();
}  // namespace finegauge

// The parser asserts some of what it should refuse (a key that begins with a strange character): in a debug build noise
// would stop the program, and in a release build the condition is assumed, whatever follows. As an exception it is one
// more refusal. This is the one place that includes the parser.
#define TOML_ASSERT(condition) ((condition) ? static_cast<void>(0) : ::finegauge::refuse_unparsable())
#pragma push_macro("NDEBUG")
#undef NDEBUG  // with it the parser sets its own TOML_ASSERT
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")
#include <cassert>  // again, as the macro that NDEBUG asks for

namespace finegauge {

/// A scene file as parsed, with the overrides of `--set` applied. Knows where a field came from, so that every message
/// can say so; knows nothing of which keys exist.
class SceneDocument {
 public:
  /// Throws SceneError when the file or an override cannot be read. `text_keys` tells which fields (paths without
  /// indices) hold text, and may therefore be given without quotes.
  SceneDocument(const std::filesystem::path& file, std::span<const std::string> overrides,
                bool (*is_text)(const std::string& section, const std::string& key));

  const std::filesystem::path& file() const { return file_; }
  const toml::table& root() const { return root_; }

  /// Throws SceneError "FILE:LINE: field: what", or "--set KEY=VALUE: field: what" for a field that was set by one.
  /// `line` is that of the file; 0 when the field is not in the file.
  [[noreturn]] void fail(const std::string& field, toml::source_index line, const std::string& what) const;

 private:
  struct Override {
    std::string field;  // as fields are written in messages: section[index].key
    std::string text;   // as given
  };
  void apply(const std::string& text, bool (*is_text)(const std::string&, const std::string&));

  std::filesystem::path file_;
  toml::table root_;
  std::vector<Override> overrides_;
};

/// A value as it may stand in a message.
std::string excerpt(const toml::node& node);

}  // namespace finegauge
