/// \file
/// Who may ask the studio: the token, and a Host and Origin that are ours. Other pages in the same browser, and names
/// that a foreign name server points at this machine, are refused.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/studio/http.h"

namespace patinate::studio {

/// 128 bits of the system's randomness as 32 hexadecimal digits. @throws CannotComplete if there is none.
[[nodiscard]] std::string random_token();

class Access {
 public:
  /// @param hosts  Names that a Host header may have beside 127.0.0.1, localhost and [::1], without port.
  Access(std::string token, int port, const std::vector<std::string>& hosts);

  /// Why a request is refused, in one sentence; "" when it may be answered.
  [[nodiscard]] std::string refusal(const HttpRequest& request) const;
  /// `GET /?token=TOKEN` with the right token, from a host that is ours: it is answered with the cookie.
  [[nodiscard]] bool is_entry(const HttpRequest& request) const;
  /// "patinate-PORT=TOKEN; HttpOnly; SameSite=Strict; Path=/"
  [[nodiscard]] std::string cookie() const;

 private:
  [[nodiscard]] bool is_ours(std::string_view host) const;
  [[nodiscard]] std::string foreign(const HttpRequest& request) const;
  [[nodiscard]] bool is_token(std::string_view given) const;

  std::string token_;
  std::string cookie_name_;
  std::vector<std::string> hosts_;
};

}  // namespace patinate::studio
