#include "tools/studio/access.h"

#include <gtest/gtest.h>

#include "patinate/core/error.h"

namespace patinate::studio {
namespace {

constexpr const char* kToken = "0123456789abcdef0123456789abcdef";

HttpRequest request(const std::string& host, const std::string& cookie, const std::string& origin = "") {
  HttpRequest r{.method = "GET", .target = "/api/places", .headers = {{"host", host}}, .body = {}};
  if (!cookie.empty()) r.headers["cookie"] = cookie;
  if (!origin.empty()) r.headers["origin"] = origin;
  return r;
}

class AccessTest : public ::testing::Test {
 protected:
  Access access_{kToken, 8123, {"Lab.Example"}};
  std::string cookie_ = std::string("patinate-8123=") + kToken;
  [[nodiscard]] bool admits(const HttpRequest& r) const { return access_.refusal(r).empty(); }
};

TEST_F(AccessTest, AdmitsThisMachineByAnyPortAndNamesThatAreAllowed) {
  for (const char* host :
       {"127.0.0.1:8123", "localhost:9000", "[::1]:8123", "LOCALHOST", "lab.example:80", "127.0.0.1"}) {
    EXPECT_TRUE(admits(request(host, cookie_))) << host;
  }
}

TEST_F(AccessTest, RefusesOtherHostsAlsoThoseThatBeginLikeOurs) {
  for (const char* host :
       {"", "evil.example", "127.0.0.1.evil.example", "localhost:80@evil", "localhost.evil:80", "127.0.0.1:80:80",
        "127.0.0.1:", "[::1]x", "lab.example.evil", "127.0.0.1:123456", "localhost, evil"}) {
    EXPECT_FALSE(admits(request(host, cookie_))) << host;
  }
}

TEST_F(AccessTest, RefusesAnotherOriginEvenWithTheCookie) {
  EXPECT_TRUE(admits(request("localhost:8123", cookie_, "http://localhost:8123")));
  for (const char* origin : {"null", "http://localhost:8124", "http://127.0.0.1:8123", "https://localhost:8123",
                             "http://evil.example", "file://", "http://localhost:8123.evil"}) {
    EXPECT_FALSE(admits(request("localhost:8123", cookie_, origin))) << origin;
  }
}

TEST_F(AccessTest, WantsTheWholeTokenAsCookieOrBearer) {
  HttpRequest bearer = request("localhost", "");
  EXPECT_FALSE(admits(bearer));
  bearer.headers["authorization"] = std::string("Bearer ") + kToken;
  EXPECT_TRUE(admits(bearer));
  bearer.headers["authorization"] = std::string("Bearer ") + kToken + "0";
  EXPECT_FALSE(admits(bearer));
  bearer.headers["authorization"] = std::string("Basic ") + kToken;
  EXPECT_FALSE(admits(bearer));
  EXPECT_TRUE(admits(request("localhost", "theme=dark; " + cookie_ + "; x=y")));
  for (const std::string& cookie :
       {std::string("patinate-8123="), std::string("patinate-8123=0123"), std::string("patinate-8124=") + kToken,
        std::string("xpatinate-8123=") + kToken, cookie_ + "00"}) {
    EXPECT_FALSE(admits(request("localhost", cookie))) << cookie;
  }
}

TEST_F(AccessTest, OnlyTheRightTokenInTheAddressGivesTheCookie) {
  HttpRequest entry{
      .method = "GET", .target = std::string("/?token=") + kToken, .headers = {{"host", "localhost:8123"}}, .body = {}};
  EXPECT_TRUE(access_.is_entry(entry));
  EXPECT_NE(access_.cookie().find("HttpOnly; SameSite=Strict"), std::string::npos);
  HttpRequest wrong = entry;
  wrong.target.back() = 'e';
  EXPECT_FALSE(access_.is_entry(wrong));
  wrong = entry;
  wrong.headers["host"] = "evil.example";
  EXPECT_FALSE(access_.is_entry(wrong));
  wrong = entry;
  wrong.target = "/?token=%zz";
  EXPECT_FALSE(access_.is_entry(wrong));
}

TEST(RandomToken, DiffersEveryTimeAndHas128Bits) {
  const std::string token = random_token();
  EXPECT_EQ(token.size(), 32u);
  EXPECT_NE(token, random_token());
}

TEST(RequestTarget, DecodesOnceAndRefusesNulAndBrokenEscapes) {
  const RequestTarget target = parse_target("/api/file?place=a%20b+c&path=x%2Fy%252e&path=second&flag");
  EXPECT_EQ(target.path, "/api/file");
  EXPECT_EQ(target.value("place"), "a b c");
  EXPECT_EQ(target.value("path"), "x/y%2e");
  EXPECT_TRUE(target.has("flag"));
  for (const char* bad : {"", "api", "/%0", "/%", "/%zz", "/a?b=%00", "/%00", "http://x/"})
    EXPECT_THROW((void)parse_target(bad), InvalidInput) << bad;
}

TEST(RequestTarget, ReadsBackWhatWasEncoded) {
  const std::string text = "Übung & co/100 %+?#=.json";
  EXPECT_EQ(parse_target("/?a=" + percent_encoded(text)).value("a"), text);
}

}  // namespace
}  // namespace patinate::studio
