#include "libcommon/core/expression.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

using Node = ExpressionNode;
using NodePtr = std::unique_ptr<Node>;
using Kind = Node::Kind;

constexpr int kMaxDepth = 100;
constexpr std::size_t kMaxLength = 10'000;

struct Function {
  std::string_view name;
  Kind kind;
  std::size_t least;  ///< Operands.
  std::size_t most;
};
constexpr std::size_t kAnyNumber = 1000;
constexpr std::array<Function, 6> kFunctions{{{"min", Kind::Min, 1, kAnyNumber},
                                              {"max", Kind::Max, 1, kAnyNumber},
                                              {"abs", Kind::Abs, 1, 1},
                                              {"pow", Kind::Pow, 2, 2},
                                              {"clamp", Kind::Clamp, 3, 3},
                                              {"smoothstep", Kind::Smoothstep, 3, 3}}};

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Whether a word reads as a path: by how it begins, or by an extension that begins with a letter.
bool looks_like_file(std::string_view word) {
  if (word.starts_with('/') || word.starts_with("./") || word.starts_with("../") || word.starts_with('~')) return true;
  const std::size_t dot = word.rfind('.');
  return dot != std::string_view::npos && dot > 0 && dot + 1 < word.size() && is_letter(word[dot + 1]) &&
         word.find('/', dot) == std::string_view::npos;
}

class Parser {
 public:
  Parser(std::string_view text, const ExpressionSyntax& syntax, std::vector<ExpressionName>& names)
      : text_(text), syntax_(syntax), names_(names) {}

  NodePtr parse() {
    if (text_.size() > kMaxLength) fail(0, "an expression of at most " + std::to_string(kMaxLength) + " characters");
    NodePtr root = sum();
    if (!at_end()) fail(at_, "an operator or the end");
    return root;
  }

 private:
  [[nodiscard]] std::string place(std::size_t at) const {
    return syntax_.subject + " `" + std::string(text_.substr(0, 200)) + "`: position " + std::to_string(at + 1) + ": ";
  }
  [[noreturn]] void fail(std::size_t at, const std::string& expected) const {
    const std::string found = at < text_.size() ? "`" + std::string(1, text_[at]) + "`" : "the end";
    throw ParseError(place(at) + "found " + found + "; expected " + expected);
  }

  bool at_end() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
    return at_ == text_.size();
  }
  bool take(char c) {
    if (at_end() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!take(c)) fail(at_, std::string("`") + c + "`");
  }

  static NodePtr make(Kind kind, NodePtr a, NodePtr b = nullptr) {
    auto node = std::make_unique<Node>();
    node->kind = kind;
    node->operands.push_back(std::move(a));
    if (b) node->operands.push_back(std::move(b));
    return node;
  }

  NodePtr sum() {
    NodePtr left = product();
    while (true) {
      if (take('+')) {
        left = make(Kind::Add, std::move(left), product());
      } else if (take('-')) {
        left = make(Kind::Subtract, std::move(left), product());
      } else {
        return left;
      }
    }
  }

  NodePtr product() {
    NodePtr left = factor();
    while (true) {
      if (take('*')) {
        left = make(Kind::Multiply, std::move(left), factor());
      } else if (take('/')) {
        left = make(Kind::Divide, std::move(left), factor());
      } else {
        return left;
      }
    }
  }

  NodePtr factor() {
    if (++depth_ > kMaxDepth) fail(at_, "at most " + std::to_string(kMaxDepth) + " levels of nesting");
    NodePtr node;
    if (take('!')) {
      node = make(Kind::Invert, factor());
    } else if (take('-')) {
      node = make(Kind::Negate, factor());
    } else if (take('(')) {
      node = sum();
      expect(')');
    } else {
      node = operand();
    }
    --depth_;
    return node;
  }

  NodePtr operand() {
    if (at_end()) fail(at_, "a number, a " + syntax_.name + " or `(`");
    const char c = text_[at_];
    if (c == '"' && syntax_.has_files) return quoted();
    if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) {
      if (const std::string_view word = path_word(); syntax_.has_files && looks_like_file(word)) return file(word);
      return number();
    }
    if (const std::string_view word = path_word(); syntax_.has_files && looks_like_file(word)) return file(word);
    if (is_letter(c)) return name();
    fail(at_, "a number, a " + syntax_.name + " or `(`");
  }

  NodePtr number() {
    auto node = std::make_unique<Node>();
    const auto result = std::from_chars(text_.data() + at_, text_.data() + text_.size(), node->number);
    if (result.ec != std::errc() || std::abs(node->number) > kExpressionHuge) fail(at_, "a number of at most 1e30");
    at_ = static_cast<std::size_t>(result.ptr - text_.data());
    return node;
  }

  NodePtr quoted() {
    const std::size_t end = text_.find('"', at_ + 1);
    if (end == std::string_view::npos || end == at_ + 1) fail(at_, "a file name between two `\"`");
    NodePtr node = named({std::string(text_.substr(at_ + 1, end - at_ - 1)), true});
    at_ = end + 1;
    return node;
  }

  /// The longest run of characters that a path without quotes may have.
  [[nodiscard]] std::string_view path_word() const {
    std::size_t end = at_;
    const auto belongs = [](char c) {
      return is_letter(c) || is_digit(c) || c == '.' || c == '/' || c == '-' || c == '~' ||
             static_cast<unsigned char>(c) >= 128;
    };
    while (end < text_.size() && belongs(text_[end])) ++end;
    return text_.substr(at_, end - at_);
  }

  NodePtr file(std::string_view word) {
    at_ += word.size();
    return named({std::string(word), true});
  }

  NodePtr name() {
    const std::size_t begin = at_;
    const auto take_word = [&] {
      while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    };
    take_word();
    // With files, a point would begin an extension.
    while (!syntax_.has_files && at_ + 1 < text_.size() && text_[at_] == '.' && is_letter(text_[at_ + 1])) {
      ++at_;
      take_word();
    }
    const std::string word(text_.substr(begin, at_ - begin));
    for (const Function& function : kFunctions) {
      if (word == function.name) return call(function);
    }
    if (std::find(syntax_.names.begin(), syntax_.names.end(), word) == syntax_.names.end()) fail_unknown(begin, word);
    ExpressionName found{word, false};
    if (syntax_.check_argument && take('(')) {
      do found.arguments.push_back(argument(found));
      while (take(','));
      expect(')');
    }
    return named(std::move(found));
  }

  /// `scale=3`, `direction=0,1,0`, `file="a map.exr"`.
  std::pair<std::string, std::string> argument(const ExpressionName& of) {
    (void)at_end();
    const std::size_t begin = at_;
    std::string word = argument_word();
    if (word.empty() || !take('=')) fail(begin, "an argument, such as scale=3");
    const std::string value = argument_value();
    try {
      syntax_.check_argument(of.text, word, value);
    } catch (const ParseError& e) {
      throw ParseError(place(begin) + e.what());
    }
    for (const auto& [other, ignored] : of.arguments) {
      if (other == word) throw ParseError(place(begin) + "`" + word + "` is given twice");
    }
    return {std::move(word), value};
  }

  std::string argument_word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]) || text_[at_] == '-')) ++at_;
    std::string word(text_.substr(begin, at_ - begin));
    std::replace(word.begin(), word.end(), '-', '_');
    return word;
  }

  std::string argument_value() {
    if (at_end()) fail(at_, "a value");
    if (text_[at_] == '"') {
      const std::size_t end = text_.find('"', at_ + 1);
      if (end == std::string_view::npos) fail(at_, "a value between two `\"`");
      const std::string value(text_.substr(at_ + 1, end - at_ - 1));
      at_ = end + 1;
      return value;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != ')' && !(text_[at_] == ',' && is_argument(at_ + 1))) ++at_;
    std::size_t end = at_;
    while (end > begin && std::isspace(static_cast<unsigned char>(text_[end - 1])) != 0) --end;
    return std::string(text_.substr(begin, end - begin));
  }

  /// `WORD=` begins at a place, behind blanks.
  [[nodiscard]] bool is_argument(std::size_t at) const {
    while (at < text_.size() && std::isspace(static_cast<unsigned char>(text_[at])) != 0) ++at;
    if (at == text_.size() || !is_letter(text_[at])) return false;
    while (at < text_.size() && (is_letter(text_[at]) || is_digit(text_[at]) || text_[at] == '-')) ++at;
    while (at < text_.size() && std::isspace(static_cast<unsigned char>(text_[at])) != 0) ++at;
    return at < text_.size() && text_[at] == '=';
  }

  [[noreturn]] void fail_unknown(std::size_t at, const std::string& word) const {
    std::string list;
    for (const std::string& name : syntax_.names) list += (list.empty() ? "`" : ", `") + name + "`";
    throw ParseError(place(at) + "unknown " + syntax_.name + " `" + word + "`; there are " + list +
                     (syntax_.has_files ? ", and files such as `map.exr`" : "") + did_you_mean(word, syntax_.names));
  }

  NodePtr call(const Function& function) {
    expect('(');
    NodePtr node = make(function.kind, sum());
    while (node->operands.size() < function.least) {
      expect(',');
      node->operands.push_back(sum());
    }
    while (node->operands.size() < function.most && take(',')) node->operands.push_back(sum());
    expect(')');
    return node;
  }

  NodePtr named(ExpressionName name) {
    auto node = std::make_unique<Node>();
    node->kind = Kind::Name;
    const auto found = std::find(names_.begin(), names_.end(), name);
    node->name = static_cast<std::size_t>(found - names_.begin());
    if (found == names_.end()) names_.push_back(std::move(name));
    return node;
  }

  std::string_view text_;
  const ExpressionSyntax& syntax_;
  std::vector<ExpressionName>& names_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Expression parse_expression(std::string_view text, const ExpressionSyntax& syntax) {
  Expression out;
  out.root = Parser(text, syntax, out.names).parse();
  return out;
}

}  // namespace patinate
