#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace finegauge {

/// The words of a gmsh file one after another, each checked as it is taken; remembers the line for messages.
/// Numbers must be followed by white space, so that noise never passes for data.
class GmshTokens {
 public:
  /// `text` must outlive the tokens.
  GmshTokens(std::string file, std::string_view text) : file_(std::move(file)), rest_(text) {}

  std::string word(const std::string& field);
  std::int64_t integer(const char* field, std::int64_t low, std::int64_t high);
  double number(const char* field);  ///< finite
  std::string quoted(const char* field);
  void expect(const std::string& section);
  void skip_to(const std::string& section);  ///< past a line that is this word
  bool at_end();

  std::size_t line() const { return line_; }  ///< of the word taken last

  [[noreturn]] void fail(const std::string& field, const std::string& what) const { fail_at(line_, field, what); }
  [[noreturn]] void fail_at(std::size_t line, const std::string& field, const std::string& what) const;

 private:
  std::string_view take(const char* field);
  void skip_space();

  std::string file_;
  std::string_view rest_;
  std::size_t next_line_ = 1;
  std::size_t line_ = 1;
};

}  // namespace finegauge
