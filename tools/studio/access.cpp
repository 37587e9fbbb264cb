#include "tools/studio/access.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "libcommon/core/file_name.h"
#include "patinate/core/error.h"

namespace patinate::studio {

namespace {

bool is_port(std::string_view text) {
  return text.size() <= 5 && !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// The value of a cookie; "" when there is none of that name.
std::string_view cookie_value(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    std::string_view pair = cookies.substr(0, cookies.find_first_of(";,"));
    cookies.remove_prefix(std::min(cookies.size(), pair.size() + 1));
    pair.remove_prefix(std::min(pair.size(), pair.find_first_not_of(' ')));
    if (pair.size() > name.size() && pair.substr(0, name.size()) == name && pair[name.size()] == '=')
      return pair.substr(name.size() + 1);
  }
  return {};
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw CannotComplete("the system gives no random numbers for a token");
  static constexpr std::string_view kHex = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bytes) token += {kHex[byte / 16], kHex[byte % 16]};
  return token;
}

Access::Access(std::string token, int port, const std::vector<std::string>& hosts)
    : token_(std::move(token)),
      cookie_name_("patinate-" + std::to_string(port)),
      hosts_{"127.0.0.1", "localhost", "[::1]"} {
  for (const std::string& host : hosts) hosts_.push_back(lower_case(host));
}

std::string Access::cookie() const { return cookie_name_ + "=" + token_ + "; HttpOnly; SameSite=Strict; Path=/"; }

bool Access::is_ours(std::string_view host) const {
  const std::string asked = lower_case(host);
  return std::any_of(hosts_.begin(), hosts_.end(), [&](const std::string& ours) {
    return asked == ours || (asked.size() > ours.size() && asked.compare(0, ours.size(), ours) == 0 &&
                             asked[ours.size()] == ':' && is_port(std::string_view(asked).substr(ours.size() + 1)));
  });
}

/// All bytes are looked at, so that time tells nothing.
bool Access::is_token(std::string_view given) const {
  if (given.size() != token_.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < given.size(); ++i) difference |= static_cast<unsigned>(given[i] ^ token_[i]);
  return difference == 0;
}

std::string Access::foreign(const HttpRequest& request) const {
  const std::string_view host = request.header("host");
  if (!is_ours(host)) return "this name is not allowed as Host; start the studio with --allow-host NAME to allow it";
  const std::string_view origin = request.header("origin");
  if (!origin.empty() && lower_case(origin) != "http://" + lower_case(host))
    return "requests from other pages are not answered";
  return {};
}

std::string Access::refusal(const HttpRequest& request) const {
  if (std::string why = foreign(request); !why.empty()) return why;
  constexpr std::string_view kBearer = "Bearer ";
  const std::string_view authorization = request.header("authorization");
  if (authorization.substr(0, kBearer.size()) == kBearer && is_token(authorization.substr(kBearer.size()))) return {};
  if (is_token(cookie_value(request.header("cookie"), cookie_name_))) return {};
  return "open the address that `patinate studio` printed: it ends with a token";
}

bool Access::is_entry(const HttpRequest& request) const {
  if (request.method != "GET" || !foreign(request).empty()) return false;
  try {
    const RequestTarget target = parse_target(request.target);
    return target.path == "/" && is_token(target.value("token"));
  } catch (const InvalidInput&) {
    return false;
  }
}

}  // namespace patinate::studio
