#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace finegauge {

/// A whole file. Throws SceneError unless it is a regular, readable file of at most `size_limit` bytes that is not
/// empty; the size is looked at before anything is read.
std::string read_text_file(const std::filesystem::path& file, std::uintmax_t size_limit);

/// Text from outside as it may stand in a message: one line, printable, at most `longest` characters.
std::string quoted_excerpt(const std::string& text, std::size_t longest = 60);

}  // namespace finegauge
