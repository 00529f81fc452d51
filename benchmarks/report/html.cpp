#include "benchmarks/report/html.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace finegauge {
namespace {

/// Bytes of the UTF-8 character at `at`; 0 where there is none.
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned first = byte(at);
  const std::size_t length = first < 0x80 ? 1 : first >= 0xC2 && first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if ((first >= 0x80 && first < 0xC2) || first > 0xF4 || at + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(at + k) & 0xC0U) != 0x80U) return 0;
  if (length == 1) return 1;
  // Overlong forms, surrogates and what is beyond Unicode.
  const unsigned second = byte(at + 1);
  const bool wrong = (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
                     (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
  return wrong ? 0 : length;
}

std::string formatted(const char* format, int digits, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, digits, value);
  return text;
}

std::string with_commas(const std::string& digits) {
  const std::size_t whole = std::min(digits.find('.'), digits.size());
  std::string text = digits.substr(whole);
  for (std::size_t end = whole; end > 0;) {
    const std::size_t begin = end > 3 ? end - 3 : 0;
    text = digits.substr(begin, end - begin) + (end < whole ? "," : "") + text;
    end = begin;
  }
  return text;
}

std::string superscript(int exponent) {
  static constexpr std::array<const char*, 10> digit = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) text += digit[static_cast<std::size_t>(c - '0')];
  return text;
}

}  // namespace

std::string html_escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    const char c = text[at];
    const bool control = (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7F;
    if (length == 0 || control)
      out += "\xEF\xBF\xBD";
    else if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else
      out += text.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

std::string number_text(double value, int digits) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0.0 ? "∞" : "−∞";
  if (value == 0.0) return "0";
  const double size = std::abs(value);
  const std::string sign = value < 0.0 ? "−" : "";
  if (size < 1e-3 || size >= 1e7) {
    const std::string text = formatted("%.*e", digits - 1, size);
    const std::size_t e = text.find('e');
    std::string mantissa = text.substr(0, e);
    if (mantissa.find('.') != std::string::npos) {
      mantissa.erase(mantissa.find_last_not_of('0') + 1);
      if (mantissa.back() == '.') mantissa.pop_back();
    }
    const std::string power = "10" + superscript(std::atoi(text.c_str() + e + 1));
    return sign + (mantissa == "1" ? power : mantissa + "×" + power);
  }
  const int before = static_cast<int>(std::floor(std::log10(size))) + 1;
  std::string text = formatted("%.*f", std::max(0, digits - before), size);
  if (text.find('.') != std::string::npos && std::nearbyint(value) == value) text.erase(text.find('.'));
  return sign + with_commas(text);
}

std::string bound_text(double value, int digits) {
  std::string text = number_text(value, digits);
  if (text.find('.') == std::string::npos || text.find("×") != std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string count_text(double value) {
  if (std::nearbyint(value) != value || std::abs(value) >= 1e15) return number_text(value);
  return (value < 0.0 ? "−" : "") + with_commas(formatted("%.*f", 0, std::abs(value)));
}

std::string to_html(const HtmlTable& table) {
  std::string html = "<div class=\"scroll\"><table><thead><tr>";
  for (const TableColumn& column : table.columns) {
    html +=
        std::string("<th scope=\"col\"") + (column.numeric ? " class=\"n\"" : "") + ">" + html_escaped(column.title);
    if (!column.unit.empty()) html += " <span class=\"unit\">[" + html_escaped(column.unit) + "]</span>";
    html += "</th>";
  }
  html += "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    html += i < table.failing.size() && table.failing[i] ? "<tr class=\"bad\">" : "<tr>";
    for (std::size_t c = 0; c < table.rows[i].size(); ++c) {
      const bool numeric = c < table.columns.size() && table.columns[c].numeric;
      html += (numeric ? "<td class=\"n\">" : "<td>") + table.rows[i][c] + "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string verdict_html(bool ok, std::string_view word) {
  return std::string("<span class=\"") + (ok ? "good\">✓ " : "fail\">✗ ") + html_escaped(word) + "</span>";
}

std::string details_html(const std::string& summary, const std::string& content, bool open) {
  return std::string("<details") + (open ? " open" : "") + "><summary>" + summary + "</summary>\n" + content +
         "</details>\n";
}

std::string paragraph_html(std::string_view text) { return "<p>" + html_escaped(text) + "</p>\n"; }

}  // namespace finegauge
