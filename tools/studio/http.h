/// \file
/// A request and its answer, as everything but server.cpp sees them.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace patinate::studio {

struct HttpRequest {
  std::string method;  ///< "GET", "POST"
  std::string target;  ///< Target as sent: "/api/texture?place=copper&time=3".
  std::map<std::string, std::string>
      headers;  ///< Names in lower case. Of a name that is sent twice, the values with ", " between.
  std::string body;

  /// "" when it was not sent.
  [[nodiscard]] std::string_view header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string_view() : std::string_view(found->second);
  }
};

struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::string body = {};
};

/// Request of a target, decoded.
struct RequestTarget {
  std::string path;                          ///< "/api/texture"
  std::map<std::string, std::string> query;  ///< Values by name; of a name that is given twice, the first.

  /// "" when it was not given.
  [[nodiscard]] std::string value(const std::string& name) const {
    const auto found = query.find(name);
    return found == query.end() ? std::string() : found->second;
  }
  [[nodiscard]] bool has(const std::string& name) const { return query.count(name) != 0; }
};

/// Percent signs are decoded once, `+` stands for a blank in the query. @throws InvalidInput on a broken escape, a NUL,
/// or no leading `/`.
[[nodiscard]] RequestTarget parse_target(std::string_view target);
/// The inverse, for one value of a query.
[[nodiscard]] std::string percent_encoded(std::string_view text);

}  // namespace patinate::studio
