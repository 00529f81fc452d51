#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace finegauge {

/// The words of a mesh or surface file one after another, each checked as it is taken; remembers the line for messages.
/// Numbers must be followed by white space, so that noise never passes for data.
class FileTokens {
 public:
  /// `text` must outlive the tokens; `first_line` is its place in the file.
  FileTokens(std::string file, std::string_view text, std::size_t first_line = 1)
      : file_(std::move(file)), rest_(text), next_line_(first_line), line_(first_line) {}

  std::string word(const std::string& field);
  std::int64_t integer(const char* field, std::int64_t low, std::int64_t high);
  double number(const char* field);  ///< finite; a leading + is allowed
  std::string quoted(const char* field);
  void expect(const std::string& section);
  void skip_to(const std::string& section);  ///< past a line that is this word
  bool at_end();
  bool line_ends();  ///< no word is left on this line; a backslash at its end continues it (OBJ)
  void skip_line();  ///< what is left of the line of the word taken last
  std::size_t left() const { return rest_.size(); }  ///< characters not taken yet

  std::size_t line() const { return line_; }  ///< of the word taken last

  [[noreturn]] void fail(const std::string& field, const std::string& what) const { fail_at(line_, field, what); }
  [[noreturn]] void fail_at(std::size_t line, const std::string& field, const std::string& what) const;

 private:
  std::string_view take(const char* field);
  void skip_space();

  std::string file_;
  std::string_view rest_;
  std::size_t next_line_;
  std::size_t line_;
};

}  // namespace finegauge
