#include "libcommon/controls/control_expression.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"

namespace patinate {

struct ControlExpression::Node {
  enum class Kind { Number, Map, Add, Subtract, Multiply, Divide, Negate, Invert, Min, Max, Abs, Pow, Clamp, Smoothstep };
  Kind kind = Kind::Number;
  double number = 0.0;
  std::size_t map = 0;  ///< Into names().
  std::vector<std::unique_ptr<Node>> operands;
};

namespace {

using Node = ControlExpression::Node;
using NodePtr = std::unique_ptr<Node>;
using Kind = Node::Kind;

constexpr int kMaxDepth = 100;
constexpr std::size_t kMaxLength = 10'000;
constexpr double kHuge = 1e30;  ///< Values are kept below it, so that none becomes infinite or NaN.

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
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Whether a word reads as a path: by how it begins, or by an extension that begins with a letter.
bool looks_like_file(std::string_view word) {
  if (word.starts_with('/') || word.starts_with("./") || word.starts_with("../") || word.starts_with('~')) return true;
  const std::size_t dot = word.rfind('.');
  return dot != std::string_view::npos && dot > 0 && dot + 1 < word.size() && is_letter(word[dot + 1]) &&
         word.find('/', dot) == std::string_view::npos;
}

class Parser {
 public:
  Parser(std::string_view text, std::span<const std::string> known, std::vector<ControlName>& names)
      : text_(text), known_(known), names_(names) {}

  NodePtr parse() {
    if (text_.size() > kMaxLength) fail(0, "an expression of at most " + std::to_string(kMaxLength) + " characters");
    NodePtr root = sum();
    if (!at_end()) fail(at_, "an operator or the end");
    return root;
  }

 private:
  [[noreturn]] void fail(std::size_t at, const std::string& expected) const {
    const std::string found = at < text_.size() ? "`" + std::string(1, text_[at]) + "`" : "the end";
    throw UsageError("control `" + std::string(text_.substr(0, 200)) + "`: position " + std::to_string(at + 1) +
                     ": found " + found + "; expected " + expected);
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
    if (at_end()) fail(at_, "a number, a control or `(`");
    const char c = text_[at_];
    if (c == '"') return quoted();
    if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) {
      if (const std::string_view word = path_word(); looks_like_file(word)) return file(word);
      return number();
    }
    if (const std::string_view word = path_word(); looks_like_file(word)) return file(word);
    if (is_letter(c)) return name();
    fail(at_, "a number, a control or `(`");
  }

  NodePtr number() {
    auto node = std::make_unique<Node>();
    const auto result = std::from_chars(text_.data() + at_, text_.data() + text_.size(), node->number);
    if (result.ec != std::errc() || std::abs(node->number) > kHuge) fail(at_, "a number of at most 1e30");
    at_ = static_cast<std::size_t>(result.ptr - text_.data());
    return node;
  }

  NodePtr quoted() {
    const std::size_t end = text_.find('"', at_ + 1);
    if (end == std::string_view::npos || end == at_ + 1) fail(at_, "a file name between two `\"`");
    NodePtr node = map({std::string(text_.substr(at_ + 1, end - at_ - 1)), true});
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
    return map({std::string(word), true});
  }

  NodePtr name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string word(text_.substr(begin, at_ - begin));
    for (const Function& function : kFunctions) {
      if (word == function.name) return call(function);
    }
    if (std::find(known_.begin(), known_.end(), word) == known_.end()) fail_unknown(begin, word);
    return map({word, false});
  }

  [[noreturn]] void fail_unknown(std::size_t at, const std::string& word) const {
    std::string list;
    for (const std::string& name : known_) list += (list.empty() ? "`" : ", `") + name + "`";
    throw UsageError("control `" + std::string(text_.substr(0, 200)) + "`: position " + std::to_string(at + 1) +
                     ": unknown control `" + word + "`" + did_you_mean(word, known_) + "; there are " + list +
                     ", and files such as `map.exr`");
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

  NodePtr map(ControlName name) {
    auto node = std::make_unique<Node>();
    node->kind = Kind::Map;
    const auto found = std::find(names_.begin(), names_.end(), name);
    node->map = static_cast<std::size_t>(found - names_.begin());
    if (found == names_.end()) names_.push_back(std::move(name));
    return node;
  }

  std::string_view text_;
  std::span<const std::string> known_;
  std::vector<ControlName>& names_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

/// Of max(0, x): a map's values never are negative; 0 to a power below 0 is huge.
double power(double x, double exponent) {
  const double value = std::pow(std::max(0.0, x), exponent);
  return std::isfinite(value) ? value : kHuge;
}

/// 0 up to `from`, 1 beyond `to`, 3t^2 - 2t^3 between; a step when they are equal, falling when from > to.
double smoothstep(double from, double to, double x) {
  if (from == to) return x < from ? 0.0 : 1.0;
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double value_of(const Node& node, const std::vector<ControlMap>& maps, std::size_t texel) {
  const auto operand = [&](std::size_t i) { return value_of(*node.operands[i], maps, texel); };
  double value = 0.0;
  switch (node.kind) {
    case Kind::Number:
      return node.number;
    case Kind::Map:
      return static_cast<double>(maps[node.map].values.values()[texel]);
    case Kind::Add:
      value = operand(0) + operand(1);
      break;
    case Kind::Subtract:
      value = operand(0) - operand(1);
      break;
    case Kind::Multiply:
      value = operand(0) * operand(1);
      break;
    case Kind::Divide: {
      const double above = operand(0), below = operand(1);
      value = below != 0.0 ? above / below : (above > 0.0 ? kHuge : above < 0.0 ? -kHuge : 0.0);
      break;
    }
    case Kind::Negate:
      return -operand(0);
    case Kind::Invert:
      value = 1.0 - operand(0);
      break;
    case Kind::Min:
    case Kind::Max:
      value = operand(0);
      for (std::size_t i = 1; i < node.operands.size(); ++i) {
        value = node.kind == Kind::Min ? std::min(value, operand(i)) : std::max(value, operand(i));
      }
      return value;
    case Kind::Abs:
      return std::abs(operand(0));
    case Kind::Pow:
      value = power(operand(0), operand(1));
      break;
    case Kind::Clamp:
      return std::max(operand(1), std::min(operand(0), operand(2)));
    case Kind::Smoothstep:
      return smoothstep(operand(0), operand(1), operand(2));
  }
  return std::clamp(value, -kHuge, kHuge);
}

}  // namespace

ControlExpression::ControlExpression(std::string_view text, std::span<const std::string> known_names)
    : root_(Parser(text, known_names, names_).parse()) {}
ControlExpression::~ControlExpression() = default;
ControlExpression::ControlExpression(ControlExpression&&) noexcept = default;
ControlExpression& ControlExpression::operator=(ControlExpression&&) noexcept = default;

ControlMap ControlExpression::evaluate(const ImageU8& coverage,
                                       const std::function<ControlMap(const ControlName&)>& lookup) const {
  std::vector<ControlMap> maps;
  for (const ControlName& name : names_) {
    maps.push_back(lookup(name));
    const ImageF& values = maps.back().values;
    if (!values.same_size(coverage) || values.channels() != 1) {
      throw InvalidInput("control `" + name.text + "`: its map is " + std::to_string(values.width()) + " x " +
                         std::to_string(values.height()) + "; the atlas is " + std::to_string(coverage.width()) +
                         " x " + std::to_string(coverage.height()));
    }
  }
  ControlMap out{ImageF(coverage.width(), coverage.height()), 0.0, 1.0, "relative", {}};
  for (const ControlMap& map : maps) out.notes.insert(out.notes.end(), map.notes.begin(), map.notes.end());
  for (std::size_t i = 0; i < coverage.values().size(); ++i) {
    if (coverage.values()[i] == 0) continue;
    const double value = value_of(*root_, maps, i);
    out.values.values()[i] = value > 0.0 ? static_cast<float>(std::min(value, 1.0)) : 0.0F;
  }
  const bool is_inverted = root_->kind == Kind::Invert;
  const Node& inner = is_inverted ? *root_->operands[0] : *root_;
  if (inner.kind == Kind::Map) {
    const ControlMap& map = maps[inner.map];
    out.low = is_inverted ? map.high : map.low;
    out.high = is_inverted ? map.low : map.high;
    out.unit = map.unit;
  }
  return out;
}

}  // namespace patinate
