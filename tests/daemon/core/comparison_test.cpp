#include "daemon/core/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace odomd::daemon::comparison_test {
namespace {

constexpr double memory = 20.0;
constexpr Comparison::Bounds plain{0.0, 0.0, 0.1};

double wave(int k) {
  return std::sin(0.7 * k);
}

TEST(Comparison, KnowsNothingAtFirst) {
  const Comparison comparison;
  EXPECT_FALSE(comparison.shows(plain, 0.0));
  EXPECT_EQ(comparison.correlation(plain), 0.0);
  EXPECT_EQ(comparison.gain(plain), 0.0);
}

TEST(Comparison, ReportsSignAndFactor) {
  Comparison comparison;
  for (int k = 0; k < 40; ++k) comparison.add(-3.6 * wave(k), wave(k), plain, memory);
  EXPECT_TRUE(comparison.shows(plain, 10.0));
  EXPECT_NEAR(comparison.correlation(plain), -1.0, 1e-9);
  EXPECT_NEAR(comparison.gain(plain), 3.6, 1e-9);
}

TEST(Comparison, ShowsOnlyWithEnoughPiecesAndEnoughInThem) {
  Comparison comparison;
  for (int k = 0; k < 9; ++k) comparison.add(wave(k), wave(k), plain, memory);
  EXPECT_FALSE(comparison.shows(plain, 10.0));
  for (int k = 9; k < 40; ++k) comparison.add(wave(k), wave(k), plain, memory);
  EXPECT_TRUE(comparison.shows(plain, 10.0));
  EXPECT_FALSE(comparison.shows({0.0, 0.0, 2.0}, 10.0));
}

TEST(Comparison, PassesOverAnOffsetWithinItsBoundAndNotBeyond) {
  Comparison comparison;
  for (int k = 0; k < 40; ++k) comparison.add(0.5 + wave(k), wave(k), plain, memory);
  EXPECT_NEAR(comparison.correlation({1.0, 1.0, 0.1}), 1.0, 1e-6);
  Comparison steady;  // a steady turn that one of them has the other way
  for (int k = 0; k < 40; ++k) steady.add(-0.8, 0.8, plain, memory);
  EXPECT_NEAR(steady.correlation({0.1, 0.1, 0.1}), -1.0, 1e-6);
  EXPECT_NEAR(steady.correlation({1.0, 0.1, 0.1}), 0.0, 1e-9);
}

TEST(Comparison, ForgetsWhatIsLongAgo) {
  Comparison comparison;
  for (int k = 0; k < 40; ++k) comparison.add(-wave(k), wave(k), plain, memory);
  for (int k = 0; k < 100; ++k) comparison.add(wave(k), wave(k), plain, memory);
  EXPECT_GT(comparison.correlation(plain), 0.95);
}

TEST(Comparison, ForgetsAUnitAsSoonAsASign) {
  const auto pieces_to_forget = [](double factor) {
    Comparison comparison;
    for (int k = 0; k < 100; ++k) comparison.add(factor * wave(k), wave(k), plain, memory);
    EXPECT_NEAR(comparison.gain(plain), std::abs(factor), 0.01 * std::abs(factor));
    int pieces = 0;
    for (; pieces < 1000; ++pieces) {
      if (comparison.correlation(plain) > 0.7 && comparison.gain(plain) < 2.0) break;
      comparison.add(wave(pieces), wave(pieces), plain, memory);
    }
    return pieces;
  };
  const int of_a_sign = pieces_to_forget(-1.0);
  for (const double unit : {57.3, 1000.0, 3.6, 0.1, 1.0 / 57.3})
    EXPECT_LE(pieces_to_forget(unit), of_a_sign) << unit;
}

TEST(Comparison, TakesWhatHasNoSquareWithoutHarm) {
  Comparison comparison;
  comparison.add(1e300, -1e300, plain, memory);
  for (int k = 0; k < 200; ++k) comparison.add(wave(k), wave(k), plain, memory);
  EXPECT_NEAR(comparison.gain(plain), 1.0, 0.01);
}

}  // namespace
}  // namespace odomd::daemon::comparison_test
