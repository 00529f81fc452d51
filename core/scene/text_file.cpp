#include "core/scene/text_file.hpp"

#include <fstream>
#include <system_error>

#include "core/scene/scene_error.hpp"

namespace finegauge {

std::string read_text_file(const std::filesystem::path& file, std::uintmax_t size_limit) {
  const std::string name = file.string();
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw SceneError(name + ": no such file");
  if (std::filesystem::is_directory(status)) throw SceneError(name + ": found a directory, allowed a file");
  if (!std::filesystem::is_regular_file(status)) throw SceneError(name + ": not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw SceneError(name + ": cannot be read: " + error.message());
  if (size == 0) throw SceneError(name + ":1: the file is empty");
  if (size > size_limit)
    throw SceneError(name + ": found " + std::to_string(size) + " bytes, allowed at most " +
                     std::to_string(size_limit));
  std::ifstream in(file, std::ios::binary);
  std::string text(size, '\0');
  in.read(text.data(), static_cast<std::streamsize>(size));
  if (!in) throw SceneError(name + ": cannot be read");
  return text;
}

std::string quoted_excerpt(const std::string& text, std::size_t longest) {
  std::string excerpt;
  bool space = false;
  for (const char c : text) {
    if (excerpt.size() >= longest) return excerpt + "...";
    if (c == ' ' || c == '\n' || c == '\t' || c == '\r') {
      if (!space) excerpt += ' ';
      space = true;
      continue;
    }
    space = false;
    excerpt += (c > ' ' && c <= '~') ? c : '?';
  }
  return excerpt;
}

}  // namespace finegauge
