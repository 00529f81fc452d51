#include "benchmarks/report/svg_text.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>

namespace finegauge {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
         c == ':' || c == '.';
}

class Reader {
 public:
  explicit Reader(const std::string& text) : text_(text) {}

  std::vector<SvgPart> read() {
    std::vector<std::string> open;
    std::vector<SvgPart> parts;
    bool done = false;
    while (at_ < text_.size()) {
      if (text_[at_] != '<') {
        const std::size_t end = std::min(text_.find('<', at_), text_.size());
        std::string between = text_.substr(at_, end - at_);
        at_ = end;
        if (open.empty() && !std::ranges::all_of(between, is_space) && !(at_ <= 3 + between.size() && parts.empty()))
          fail("there is text outside the drawing");
        if (!open.empty()) parts.push_back({SvgPart::Kind::text, {}, std::move(between)});
      } else if (starts("<!--")) {
        skip_to("-->");
      } else if (starts("<?")) {
        skip_to("?>");
      } else if (starts("<![CDATA[") || starts("<!ENTITY")) {
        fail("it has character data or entities of its own");
      } else if (starts("<!")) {
        skip_to(">");
        if (text_[at_ - 2] == ']' || text_.substr(0, at_).find('[') != std::string::npos)
          fail("it declares a document type of its own");
      } else if (starts("</")) {
        at_ += 2;
        const std::string name = read_name();
        skip_space();
        expect('>');
        if (open.empty() || open.back() != name) fail("</" + name + "> closes nothing");
        open.pop_back();
        parts.push_back({SvgPart::Kind::end, name, {}});
        done = open.empty();
      } else {
        if (done) fail("there is more than one drawing");
        parts.push_back(read_tag());
        if (parts.back().kind == SvgPart::Kind::begin) open.push_back(parts.back().name);
      }
    }
    if (!open.empty()) fail("<" + open.back() + "> is not closed");
    if (parts.empty() || parts.front().name != "svg") fail("it is no drawing");
    return parts;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error("byte " + std::to_string(at_) + ": " + what);
  }
  bool starts(std::string_view with) const { return std::string_view(text_).substr(at_).starts_with(with); }
  void skip_to(const std::string& end) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string::npos) fail("it ends in a comment or declaration");
    at_ = found + end.size();
  }
  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }
  void expect(char c) {
    if (at_ >= text_.size() || text_[at_] != c) fail(std::string("there should be a ") + c);
    ++at_;
  }
  std::string read_name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_name(text_[at_])) ++at_;
    if (at_ == begin) fail("a name is missing");
    return text_.substr(begin, at_ - begin);
  }
  SvgPart read_tag() {
    expect('<');
    SvgPart part{SvgPart::Kind::begin, read_name(), {}};
    for (skip_space(); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/'; skip_space()) {
      const std::string key = read_name();
      skip_space();
      expect('=');
      skip_space();
      const char quote = at_ < text_.size() ? text_[at_] : ' ';
      if (quote != '"' && quote != '\'') fail("the value of " + key + " has no quotation marks");
      const std::size_t end = text_.find(quote, ++at_);
      if (end == std::string::npos) fail("the value of " + key + " does not end");
      part.attributes.emplace_back(key, text_.substr(at_, end - at_));
      at_ = end + 1;
    }
    if (at_ < text_.size() && text_[at_] == '/') {
      part.kind = SvgPart::Kind::whole;
      ++at_;
    }
    expect('>');
    return part;
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

}  // namespace

const std::string* SvgPart::attribute(const std::string& key) const {
  const auto found = std::ranges::find(attributes, key, &std::pair<std::string, std::string>::first);
  return found == attributes.end() ? nullptr : &found->second;
}

std::vector<SvgPart> parse_svg(const std::string& text) { return Reader(text).read(); }

std::string svg_text(const std::vector<SvgPart>& parts) {
  std::string text;
  for (const SvgPart& part : parts) {
    if (part.kind == SvgPart::Kind::text) {
      text += part.text;
      continue;
    }
    text += (part.kind == SvgPart::Kind::end ? "</" : "<") + part.name;
    for (const auto& [key, value] : part.attributes) {
      const char quote = value.find('"') == std::string::npos ? '"' : '\'';
      text += " " + key + "=" + quote + value + quote;
    }
    text += part.kind == SvgPart::Kind::whole ? "/>" : ">";
  }
  return text;
}

}  // namespace finegauge
