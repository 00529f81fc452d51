#include "core/scene/file_tokens.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/scene/scene_error.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

std::string shown(std::string_view word) { return "\"" + quoted_excerpt(std::string(word.substr(0, 200))) + "\""; }

}  // namespace

void FileTokens::fail_at(std::size_t line, const std::string& field, const std::string& what) const {
  throw SceneError(file_ + ":" + std::to_string(line) + ": " + quoted_excerpt(field) + ": " + what);
}

void FileTokens::skip_space() {
  std::size_t i = 0;
  for (; i < rest_.size() && is_space(rest_[i]); ++i)
    if (rest_[i] == '\n') ++next_line_;
  rest_.remove_prefix(i);
}

bool FileTokens::at_end() {
  skip_space();
  return rest_.empty();
}

bool FileTokens::line_ends() {
  while (!rest_.empty() && rest_.front() != '\n') {
    const std::size_t joined = rest_.starts_with("\\\n") ? 2 : rest_.starts_with("\\\r\n") ? 3 : 0;
    if (joined > 0) ++next_line_;
    if (joined == 0 && !is_space(rest_.front())) return false;
    rest_.remove_prefix(std::max<std::size_t>(joined, 1));
  }
  return true;
}

void FileTokens::skip_line() { rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size())); }

std::string_view FileTokens::take(const char* field) {
  skip_space();
  line_ = next_line_;
  if (rest_.empty()) fail(field, "found the end of the file");
  std::size_t size = 0;
  while (size < rest_.size() && !is_space(rest_[size])) ++size;
  const std::string_view word = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return word;
}

std::string FileTokens::word(const std::string& field) { return std::string(take(field.c_str()).substr(0, 1000)); }

std::int64_t FileTokens::integer(const char* field, std::int64_t low, std::int64_t high) {
  const std::string_view word = take(field);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || value < low || value > high)
    fail(field, "found " + shown(word) + ", allowed a whole number in [" + std::to_string(low) + ", " +
                    std::to_string(high) + "]");
  return value;
}

double FileTokens::number(const char* field) {
  const std::string_view word = take(field);
  double value = 0.0;
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  const auto [end, error] = std::from_chars(word.data() + (plus ? 1 : 0), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
    fail(field, "found " + shown(word) + ", allowed a finite number");
  return value;
}

std::string FileTokens::quoted(const char* field) {
  skip_space();
  line_ = next_line_;
  // The end of the line is not looked for: a file may be one line of many names.
  const std::size_t close = rest_.find('"', 1);
  const bool closed = rest_.starts_with('"') && close != std::string_view::npos;
  const std::string_view name = closed ? rest_.substr(1, close - 1) : std::string_view();
  if (name.empty() || name.find('\n') != std::string_view::npos)
    fail(field, "found " + shown(rest_.substr(0, rest_.find('\n'))) + ", allowed a name in double quotes");
  rest_.remove_prefix(close + 1);
  return std::string(name);
}

void FileTokens::expect(const std::string& section) {
  const std::string_view word = take(section.c_str());
  if (word != section) fail(section, "found " + shown(word) + ", allowed " + section);
}

void FileTokens::skip_to(const std::string& section) {
  const std::size_t opening_line = line_;
  while (!at_end())
    if (take(section.c_str()) == section) return;
  fail_at(opening_line, section, "found the end of the file, allowed a section that is closed");
}

}  // namespace finegauge
