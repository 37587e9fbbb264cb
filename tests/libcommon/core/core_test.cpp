#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/core/text.h"
#include "patinate/core/options.h"

namespace patinate {
namespace {

// Known answers published with Random123 (kat_vectors: philox4x32 10).
TEST(Philox, GivesTheAuthorsKnownAnswers) {
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}),
            (std::array<std::uint32_t, 4>{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (std::array<std::uint32_t, 4>{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (std::array<std::uint32_t, 4>{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomStream, DependsOnItemAndPurposeOnly) {
  RandomStream a(7, 42), b(7, 42), other_item(7, 43), other_purpose(7, 42, 1);
  const std::uint32_t first = a.next_u32();
  EXPECT_EQ(first, b.next_u32());
  EXPECT_NE(first, other_item.next_u32());
  EXPECT_NE(first, other_purpose.next_u32());
}

// Items of a device draw for themselves what one after the other draws.
TEST(RandomStream, GoesOnFromAnyWord) {
  RandomStream drawn(7, 42, 3);
  for (std::uint32_t num = 0; num < 11; ++num) {
    random_kernel::RandomState state = random_kernel::random_state_after(7, 42, 3, num);
    EXPECT_EQ(random_kernel::random_words_used(&state), num);
    EXPECT_EQ(random_kernel::random_next(&state), drawn.next_u32());
    EXPECT_EQ(random_kernel::random_words_used(&state), num + 1);
  }
}

TEST(RandomStream, BelowIsUniform) {
  // Chi-square with 9 degrees of freedom: 27.9 is exceeded with probability 0.001; the seed is fixed.
  constexpr int kDraws = 100'000;
  std::array<int, 10> counts{};
  RandomStream random(1, 2);
  for (int i = 0; i < kDraws; ++i) ++counts[random.below(10)];
  double chi2 = 0.0;
  for (int c : counts) chi2 += std::pow(c - kDraws / 10.0, 2) / (kDraws / 10.0);
  EXPECT_LT(chi2, 27.9);
}

TEST(ParallelFor, VisitsEveryIndexOnceForAnyNumberOfThreads) {
  for (int threads : {1, 2, 5}) {
    std::vector<std::atomic<int>> visits(1001);
    RunControl control;
    control.num_threads = threads;
    parallel_for(1001, 10, control, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) ++visits[i];
    });
    for (const auto& v : visits) EXPECT_EQ(v, 1);
  }
}

TEST(ParallelReduce, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto sum = [](int threads) {
    RunControl control;
    control.num_threads = threads;
    return parallel_reduce(
        100'000, 77, control, 0.0,
        [](std::int64_t begin, std::int64_t end) {
          double s = 0.0;
          for (std::int64_t i = begin; i < end; ++i) s += std::sin(static_cast<double>(i));
          return s;
        },
        [](double a, double b) { return a + b; });
  };
  EXPECT_EQ(sum(1), sum(2));
  EXPECT_EQ(sum(1), sum(7));
}

TEST(ParallelFor, StopsAndSaysSo) {
  std::stop_source source;
  RunControl control;
  control.stop = source.get_token();
  std::atomic<int> chunks{0};
  EXPECT_THROW(parallel_for(1000, 1, control,
                            [&](std::int64_t, std::int64_t) {
                              ++chunks;
                              source.request_stop();
                            }),
               Canceled);
  EXPECT_LT(chunks, 10);
}

TEST(ParallelFor, ReportsRisingFractionsThatEndAtOne) {
  std::vector<double> fractions;
  RunControl control;
  control.on_progress = [&](double f) { fractions.push_back(f); };
  parallel_for(100, 1, control, [](std::int64_t, std::int64_t) {});
  ASSERT_FALSE(fractions.empty());
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST(ParallelFor, AnErrorFromTheProgressCallbackReachesTheCaller) {
  RunControl control;
  control.num_threads = 4;
  control.on_progress = [](double) { throw CannotComplete("the window has gone"); };
  const auto slow = [](std::int64_t, std::int64_t) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
  EXPECT_THROW(parallel_for(100, 1, control, slow), CannotComplete);
}

TEST(ParallelFor, ALoopWithinALoopVisitsEachPairOnce) {
  RunControl control;
  control.num_threads = 3;
  std::vector<std::atomic<int>> visits(40 * 50);
  parallel_for(40, 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      parallel_for(50, 1, control, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t k = first; k < last; ++k) ++visits[i * 50 + k];
      });
    }
  });
  for (const auto& v : visits) EXPECT_EQ(v, 1);
}

// Ten callers that start loops of their own at once: none waits for another's, and each sees what its own loop wrote.
TEST(ParallelFor, SeveralThreadsMayEachStartLoops) {
  std::atomic<int> num_right{0};
  {
    std::vector<std::jthread> callers;
    for (int caller = 0; caller < 10; ++caller) {
      callers.emplace_back([&num_right, caller] {
        RunControl control;
        control.num_threads = 1 + caller % 4;
        for (int round = 0; round < 50; ++round) {
          std::vector<int> written(100, 0);
          parallel_for(100, 7, control, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end; ++i) written[i] = caller + 1;
          });
          if (std::count(written.begin(), written.end(), caller + 1) == 100) ++num_right;
        }
      });
    }
  }
  EXPECT_EQ(num_right, 10 * 50);
}

// Five chunks that wait for each other are all begun only if five threads run them, whatever the number of processors.
// The wait has an end so that a failure is a failure and not a hang.
TEST(ParallelFor, RunsOnAsManyThreadsAsWereAskedFor) {
  RunControl control;
  control.num_threads = 5;
  std::atomic<int> num_begun{0};
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  parallel_for(5, 1, control, [&](std::int64_t, std::int64_t) {
    ++num_begun;
    while (num_begun < 5 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    EXPECT_EQ(num_begun, 5);
  });
}

TEST(ContentHash, SeparatesValues) {
  EXPECT_NE(ContentHash().add("ab").add("c").hex(), ContentHash().add("a").add("bc").hex());
  EXPECT_EQ(ContentHash().add("ab").hex(), ContentHash().add("ab").hex());
  EXPECT_EQ(ContentHash().hex().size(), 32u);
}

TEST(Text, NumbersReadBackExactly) {
  for (double x : {0.0, 0.1, 1.0 / 3.0, 1e-300, -7.5, 12345678.9, 1e20 / 3.0, -1e-6, std::numeric_limits<double>::max(),
                   std::numeric_limits<double>::denorm_min()}) {
    EXPECT_EQ(parse_number(number_text(x)), x);
  }
  EXPECT_FALSE(parse_number("nan"));
  EXPECT_FALSE(parse_number("1.5x"));
  EXPECT_FALSE(parse_number(""));
}

// In the query of an address a plus is a blank; and the browser that asks for the same time writes 100000.
TEST(Text, NumbersHaveNoExponentWhereBrowsersWriteNone) {
  EXPECT_EQ(number_text(1e5), "100000");
  EXPECT_EQ(number_text(-3e7), "-30000000");
  EXPECT_EQ(number_text(1e20), "100000000000000000000");
  EXPECT_EQ(number_text(1e-6), "0.000001");
  EXPECT_EQ(number_text(0.0), "0");
  EXPECT_EQ(number_text(1e21), "1e+21");
  EXPECT_EQ(number_text(1e-7), "1e-07");
}

TEST(Text, RoundsToSignificantDigits) {
  EXPECT_NE(25 * 19.4, 485.0);
  EXPECT_EQ(rounded(25 * 19.4, 12), 485.0);
  EXPECT_EQ(short_number_text(0.10672227293252945), "0.106722");
  EXPECT_EQ(short_number_text(-1234567.0), "-1234570");
  EXPECT_EQ(short_number_text(1.6e9), "1600000000");
  EXPECT_EQ(short_number_text(1e-9), "1e-09");
}

TEST(Text, ShortTextsOfDifferentNumbersDiffer) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(short_number_texts(std::vector{0.0, 1.0 / 3.0, 12.5}), (Texts{"0", "0.333", "12.5"}));
  EXPECT_EQ(short_number_texts(std::vector{0.0, 120.0375, 240.075, 360.1125, 480.15}),
            (Texts{"0", "120", "240", "360", "480"}));
  EXPECT_EQ(short_number_texts(std::vector{120.0, 172.5}), (Texts{"120", "172.5"}));
  EXPECT_EQ(short_number_texts(std::vector{1.6e9, 1.6e9 + 60.0}), (Texts{"1600000000", "1600000060"}));
  EXPECT_EQ(short_number_texts(std::vector{0.3, 0.1 + 0.2}), (Texts{"0.3", "0.30000000000000004"}));
  EXPECT_EQ(short_number_texts(std::vector{2.0, 2.0}), (Texts{"2", "2"}));
}

TEST(Text, SuggestsTheWordThatWasMeant) {
  const std::vector<std::string> words{"accessibility", "facing", "spray"};
  EXPECT_EQ(did_you_mean("acessibility", words), "; did you mean `accessibility`?");
  EXPECT_EQ(did_you_mean("temperature", words), "");
}

TEST(Text, SharesAsPercent) {
  EXPECT_EQ(percent_text(0.123456), "12.3 %");
  EXPECT_EQ(percent_text(0.0012345, 2), "0.12 %");
  EXPECT_EQ(percent_text(0.0), "0 %");
  EXPECT_EQ(fixed_percent_text(0.123456), "12.3 %");
  EXPECT_EQ(fixed_percent_text(0.00012), "0 %");
  EXPECT_EQ(fixed_percent_text(1.996, 0), "200 %");
}

TEST(Text, NumbersWithZerosSortAsTheyCount) {
  EXPECT_EQ(zero_padded(7, 4), "0007");
  EXPECT_EQ(zero_padded(0, 1), "0");
  EXPECT_EQ(zero_padded(12345, 4), "12345");
}

TEST(Text, FieldsOfOptionsHaveDashesOnTheCommandLine) {
  EXPECT_EQ(dashed("low_percent"), "--low-percent");
  EXPECT_EQ(dashed("seed"), "--seed");
}

// RFC 4648, section 10.
TEST(Text, Base64IsThatOfTheStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

struct SampleOptions {
  double sigma_px = 2.0;
  int passes = 3;
};
void describe(OptionVisitor& v, SampleOptions& o) {
  v.visit({"sigma", "window", "px", above(0)}, o.sigma_px);
  v.visit({"passes", "passes", "", between(1, 9)}, o.passes);
}

TEST(Options, RangeErrorsNameTheOptionItsValueAndItsRange) {
  EXPECT_NO_THROW(check_ranges(SampleOptions{}));
  const auto message = [](SampleOptions o) -> std::string {
    try {
      check_ranges(o);
    } catch (const InvalidInput& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message({.sigma_px = 0}), "sigma: 0 is out of range; use > 0");
  EXPECT_EQ(message({.passes = 10}), "passes: 10 is out of range; use [1, 9]");
  EXPECT_NE(message({.sigma_px = std::numeric_limits<double>::quiet_NaN()}), "");
}

}  // namespace
}  // namespace patinate
