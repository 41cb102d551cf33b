#include "engine/holes/rbf/rbf.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "engine/holes/rbf/rbf_kernel.h"
#include "engine/holes/rbf/rbf_loops.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

using test::Random;

struct Samples {
  std::vector<Vec3> sites;
  std::vector<double> values;
};

using Function = std::function<double(Vec3)>;

Samples sample(const Function& f, std::size_t count, int dimension, std::uint64_t seed) {
  Random random(seed);
  Samples samples;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 x{2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
    if (dimension == 2) x.z = 0.0;
    samples.sites.push_back(x);
    samples.values.push_back(f(x));
  }
  return samples;
}

RbfInterpolant fit(const Samples& samples, const RbfOptions& options) {
  return RbfInterpolant(samples.sites, samples.values, 1, options);
}

double wave(Vec3 x) { return std::sin(2 * x.x) * std::cos(3 * x.y) + 0.5 * std::sin(2 * x.z); }
double plane(Vec3 x) { return 3.0 + 2.0 * x.x - 5.0 * x.y + 4.0 * x.z; }
double bowl(Vec3 x) {
  return plane(x) + x.x * x.x - 3 * x.x * x.y + 2 * x.y * x.y + x.z * x.z - x.y * x.z;
}

struct Form {
  int dimension;
  RbfKernel kernel;
  std::string name;
};
std::vector<Form> all_forms() {
  return {{2, RbfKernel::kBiharmonic, "plane, biharmonic"},
          {2, RbfKernel::kTriharmonic, "plane, triharmonic"},
          {3, RbfKernel::kBiharmonic, "space, biharmonic"},
          {3, RbfKernel::kTriharmonic, "space, triharmonic"}};
}
RbfOptions options_of(const Form& form) {
  RbfOptions options;
  options.dimension = form.dimension;
  options.kernel = form.kernel;
  return options;
}

TEST_CASE("LogarithmIsAccurateToTheLastPlaces") {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const double x = std::ldexp(1.0 + random.uniform(), static_cast<int>(random.below(200)) - 150);
    const double truth = std::log(x);
    REQUIRE(std::abs(rbf_log(x) - truth) <= 4e-16 * std::max(1.0, std::abs(truth)));
  }
  REQUIRE(rbf_log(1.0) == 0.0);
}

TEST_CASE("EveryVectorWidthSumsRadialFunctionsToTheSameBits") {
  std::mt19937_64 random(5);
  const auto number = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
  const RbfLoops wide = rbf_loops(), generic = rbf_loops_generic();
  for (const RbfForm form : {RbfForm::kPlaneBiharmonic, RbfForm::kPlaneTriharmonic,
                             RbfForm::kSpaceBiharmonic, RbfForm::kSpaceTriharmonic}) {
    for (const std::size_t count : {1, 2, 3, 4, 7, 64, 255}) {
      std::vector<double> x(count), y(count), z(count), weights(count);
      for (std::vector<double>* column : {&x, &y, &z, &weights})
        std::generate(column->begin(), column->end(), number);
      const RbfColumns centers{x.data(), y.data(), z.data(), weights.data(), count};
      // At a centre, where logarithm and inverse have no value of their own, and beside all.
      for (const std::array<double, 3>& place :
           {std::array{x[0], y[0], z[0]}, std::array{number(), number(), number()}}) {
        std::vector<double> phi(count), other(count);
        wide.kernel_at(form, place.data(), centers, phi.data());
        generic.kernel_at(form, place.data(), centers, other.data());
        CHECK(phi == other);
        CHECK(std::all_of(phi.begin(), phi.end(), [](double v) { return std::isfinite(v); }));
        const RbfSums sums = wide.sums_at(form, place.data(), centers);
        const RbfSums sums_of_generic = generic.sums_at(form, place.data(), centers);
        CHECK(sums.value == sums_of_generic.value);
        CHECK(sums.slope == sums_of_generic.slope);
        for (int axis = 0; axis < 3; ++axis)
          CHECK(sums.slope_by_center[axis] == sums_of_generic.slope_by_center[axis]);
      }
      std::vector<double> squared(count);
      std::generate(squared.begin(), squared.end(), [&] { return std::abs(number()); });
      std::vector<double> same = squared;
      wide.kernel(form, squared.data(), count);
      generic.kernel(form, same.data(), count);
      CHECK(squared == same);
    }
  }
}

/// Columns of `size` random rows, padded with 0 to `stride`.
std::vector<double> padded_columns(std::size_t count, std::size_t size, std::size_t stride,
                                   std::mt19937_64& random) {
  std::vector<double> values(count * stride, 0.0);
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t i = 0; i < size; ++i)
      values[k * stride + i] = static_cast<double>(random() >> 11) * 0x1p-53 - 0.5;
  return values;
}

/// Symmetric, and positive definite by its diagonal.
std::vector<double> padded_matrix(std::size_t size, std::size_t stride, std::mt19937_64& random) {
  std::vector<double> matrix = padded_columns(size, size, stride, random);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < i; ++k) matrix[i * stride + k] = matrix[k * stride + i];
    matrix[i * stride + i] += 3.0 * static_cast<double>(size);
  }
  return matrix;
}

constexpr std::size_t kPaddedSizes[] = {1, 2, 3, 4, 5, 8, 11, 16, 37, 100};

TEST_CASE("EveryVectorWidthSubtractsPolynomialsToTheSameBits") {
  std::mt19937_64 random(6);
  for (const std::size_t size : kPaddedSizes) {
    INFO(size);
    const std::size_t stride = (size + 3) / 4 * 4, terms = 3;
    std::vector<double> matrix = padded_matrix(size, stride, random);
    const std::vector<double> a = padded_columns(terms, size, stride, random),
                              b = padded_columns(terms, size, stride, random),
                              c = padded_columns(terms, size, stride, random);
    const auto expected = [&, before = matrix](std::size_t i, std::size_t j) {
      double value = before[j * stride + i];
      for (std::size_t t = 0; t < terms; ++t)
        value -= a[t * stride + i] * b[t * stride + j] + c[t * stride + i] * a[t * stride + j];
      return value;
    };
    std::vector<double> other = matrix, sums(stride), other_sums(stride);
    const PaddedTerms subtracted{a.data(), b.data(), c.data(), terms};
    rbf_loops().subtract({matrix.data(), size, stride}, subtracted, sums.data());
    rbf_loops_generic().subtract({other.data(), size, stride}, subtracted, other_sums.data());
    REQUIRE(matrix == other);
    REQUIRE(sums == other_sums);
    for (std::size_t i = 0; i < size; ++i) {
      double sum = 0.0;
      for (std::size_t j = 0; j < size; ++j) {
        const double lower = expected(std::max(i, j), std::min(i, j));
        if (i >= j) CHECK(matrix[j * stride + i] == Approx(lower).margin(1e-12));
        sum += std::abs(lower);
      }
      CHECK(sums[i] == Approx(sum));
    }
  }
}

TEST_CASE("EveryVectorWidthFactorsMatricesToTheSameBits") {
  std::mt19937_64 random(7);
  const RbfLoops wide = rbf_loops(), generic = rbf_loops_generic();
  for (const std::size_t size : kPaddedSizes) {
    INFO(size);
    const std::size_t stride = (size + 3) / 4 * 4;
    std::vector<double> matrix = padded_matrix(size, stride, random);
    const std::vector<double> truth = padded_columns(1, size, stride, random);
    std::vector<double> x(stride, 0.0);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j < size; ++j) x[i] += matrix[j * stride + i] * truth[j];
    std::vector<double> other = matrix, same = x;
    REQUIRE(wide.factor({matrix.data(), size, stride}));
    REQUIRE(generic.factor({other.data(), size, stride}));
    REQUIRE(matrix == other);
    wide.solve({matrix.data(), size, stride}, x.data());
    wide.solve_transposed({matrix.data(), size, stride}, x.data());
    generic.solve({other.data(), size, stride}, same.data());
    generic.solve_transposed({other.data(), size, stride}, same.data());
    REQUIRE(x == same);
    for (std::size_t i = 0; i < stride; ++i) CHECK(x[i] == Approx(truth[i]).margin(1e-12));
  }
}

TEST_CASE("MatricesThatAreNotPositiveDefiniteAreNotFactored") {
  std::vector<double> indefinite = {1.0, 2.0, 0.0, 0.0, 2.0, 1.0, 0.0, 0.0};
  CHECK_FALSE(rbf_loops().factor({indefinite.data(), 2, 4}));
  std::vector<double> undefined(4, std::numeric_limits<double>::quiet_NaN());
  CHECK_FALSE(rbf_loops().factor({undefined.data(), 1, 4}));
}

TEST_CASE("MembersOfAFamilyAreTheInterpolantsOfTheirSmoothingToTheLastBit") {
  const Samples samples = sample(wave, 90, 2, 8);
  for (const std::uint32_t max_sites : {1200u, 40u}) {
    RbfOptions options;
    options.max_sites = max_sites;
    options.site_spacing = 0.2;
    RbfInterpolant::Family family(samples.sites, samples.values, 1, options, 3);
    for (const double length : {0.0, 0.1, 0.04}) {
      options.smoothing_length = length;
      const RbfInterpolant alone = fit(samples, options);
      const RbfInterpolant member = family.with_smoothing(length);
      REQUIRE(member.valid());
      REQUIRE(member.deviance() == alone.deviance());
      REQUIRE(member.condition() == alone.condition());
      REQUIRE(member.residual() == alone.residual());
      REQUIRE(member.evaluate({0.3, -0.2, 0.0}) == alone.evaluate({0.3, -0.2, 0.0}));
      CHECK(family.with_smoothing(length, alone.deviance() + 1.0).valid());
      CHECK_FALSE(family.with_smoothing(length, alone.deviance()).valid());
      // A family that was told of one member alone keeps nothing, and yet makes others.
      RbfInterpolant::Family single(samples.sites, samples.values, 1, options);
      CHECK(single.with_smoothing(0.0).valid());
      CHECK(single.with_smoothing(length).deviance() == alone.deviance());
    }
  }
}

TEST_CASE("PolynomialsOfTheKernelsDegreeAreReproduced") {
  for (const Form& form : all_forms()) {
    INFO(form.name);
    const bool quadratic = form.kernel == RbfKernel::kTriharmonic;
    const Function f = quadratic ? Function(bowl) : Function(plane);
    const RbfInterpolant s = fit(sample(f, 120, form.dimension, 2), options_of(form));
    REQUIRE(s.valid());
    for (const Vec3 x : sample(f, 50, form.dimension, 3).sites) {
      // Also far outside the sites.
      REQUIRE(s.evaluate(x) == Approx(f(x)).margin(1e-10));
      REQUIRE(s.evaluate(5.0 * x) == Approx(f(5.0 * x)).margin(1e-7));
    }
  }
}

TEST_CASE("InterpolantPassesThroughItsSites") {
  for (const Form& form : all_forms()) {
    INFO(form.name);
    const Samples samples = sample(wave, 400, form.dimension, 4);
    const RbfInterpolant s = fit(samples, options_of(form));
    REQUIRE(s.valid());
    REQUIRE(s.sites() == 400);
    REQUIRE(s.condition() > 1.0);
    for (std::size_t i = 0; i < samples.sites.size(); ++i) {
      REQUIRE(std::abs(s.evaluate(samples.sites[i]) - samples.values[i]) < 1e-9);
    }
    REQUIRE(s.residual() < 1e-9);
  }
}

TEST_CASE("MoreSitesComeCloserToASmoothFunction") {
  for (const Form& form : all_forms()) {
    INFO(form.name);
    const std::vector<Vec3> places = sample(wave, 100, form.dimension, 5).sites;
    std::vector<double> errors;
    for (const std::size_t count : {100u, 800u}) {
      const RbfInterpolant s = fit(sample(wave, count, form.dimension, 6), options_of(form));
      double worst = 0.0;
      for (const Vec3 x : places)
        worst = std::max(worst, std::abs(s.evaluate(0.8 * x) - wave(0.8 * x)));
      errors.push_back(worst);
    }
    REQUIRE(errors[1] < 0.5 * errors[0]);
    REQUIRE(errors[1] < 0.05);
  }
}

TEST_CASE("GradientIsTheSlopeOfTheValue") {
  for (const Form& form : all_forms()) {
    INFO(form.name);
    const RbfInterpolant s = fit(sample(wave, 200, form.dimension, 7), options_of(form));
    for (const Vec3 x : sample(wave, 50, form.dimension, 8).sites) {
      const auto [value, gradient] = s.evaluate_with_gradient(x);
      REQUIRE(value == Approx(s.evaluate(x)).margin(1e-12));
      for (int axis = 0; axis < form.dimension; ++axis) {
        Vec3 step;
        step[axis] = 1e-5;
        const double slope = (s.evaluate(x + step) - s.evaluate(x - step)) / 2e-5;
        REQUIRE(gradient[axis] == Approx(slope).epsilon(1e-4).margin(1e-4));
      }
    }
  }
}

TEST_CASE("GradientIsFiniteAtASite") {
  for (const Form& form : all_forms()) {
    const Samples samples = sample(wave, 100, form.dimension, 9);
    const RbfInterpolant s = fit(samples, options_of(form));
    REQUIRE(is_finite(s.evaluate_with_gradient(samples.sites[17]).gradient));
  }
}

TEST_CASE("ResultDoesNotDependOnUnitsOrOrigin") {
  for (const Form& form : all_forms()) {
    for (const double scale : {1e-6, 1.0, 1e6}) {
      INFO(form.name << ", scale " << scale);
      const Samples samples = sample(wave, 150, form.dimension, 10);
      const RbfInterpolant s = fit(samples, options_of(form));
      const Vec3 shift = scale * Vec3{450000.0, 5400000.0, form.dimension == 2 ? 0.0 : 300.0};
      Samples moved;
      for (std::size_t i = 0; i < samples.sites.size(); ++i) {
        moved.sites.push_back(shift + scale * samples.sites[i]);
        moved.values.push_back(scale * samples.values[i]);
      }
      const RbfInterpolant t = fit(moved, options_of(form));
      REQUIRE(t.valid());
      for (const Vec3 x : sample(wave, 20, form.dimension, 11).sites) {
        // 5.4e6 units away nine digits are left of a site, seven of its distances.
        REQUIRE(t.evaluate(shift + scale * x) ==
                Approx(scale * s.evaluate(x)).margin(1e-6 * scale));
      }
    }
  }
}

TEST_CASE("SeveralChannelsEqualSeveralInterpolants") {
  const Samples a = sample(wave, 130, 2, 12);
  const Samples b = sample(bowl, 130, 2, 12);
  std::vector<double> both;
  for (std::size_t i = 0; i < a.sites.size(); ++i) {
    both.push_back(a.values[i]);
    both.push_back(b.values[i]);
  }
  const RbfInterpolant s(a.sites, both, 2, {});
  const RbfInterpolant first = fit(a, {});
  const RbfInterpolant second = fit(b, {});
  for (const Vec3 x : sample(wave, 20, 2, 13).sites) {
    std::vector<double> out(2);
    s.evaluate(x, out);
    REQUIRE(out[0] == Approx(first.evaluate(x)).margin(1e-11));
    REQUIRE(out[1] == Approx(second.evaluate(x)).margin(1e-11));
    REQUIRE(s.evaluate(x) == out[0]);
  }
}

TEST_CASE("GreedyChoiceKeepsItsTolerance") {
  for (const Form& form : all_forms()) {
    INFO(form.name);
    const Samples samples = sample(wave, 4000, form.dimension, 14);
    RbfOptions options = options_of(form);
    options.max_sites = 1000;
    options.tolerance = form.dimension == 2 ? 0.005 : 0.05;
    const RbfInterpolant s = fit(samples, options);
    REQUIRE(s.valid());
    REQUIRE(s.sites() < 1000);
    REQUIRE(s.residual() <= options.tolerance);
    double worst = 0.0;
    for (std::size_t i = 0; i < samples.sites.size(); ++i) {
      worst = std::max(worst, std::abs(s.evaluate(samples.sites[i]) - samples.values[i]));
    }
    REQUIRE(worst == Approx(s.residual()).epsilon(1e-9));
  }
}

TEST_CASE("GreedyChoiceStopsAtTheCapAndReportsTheResidual") {
  const Samples samples = sample(wave, 2000, 2, 15);
  RbfOptions options;
  options.max_sites = 100;
  const RbfInterpolant s = fit(samples, options);
  REQUIRE(s.valid());
  REQUIRE(s.sites() == 100);
  REQUIRE(s.residual() > 0.0);
  REQUIRE(s.residual() < 0.5);
}

TEST_CASE("GreedyCentresSitWhereTheFunctionBends") {
  const Function step = [](Vec3 x) { return std::tanh(20 * x.x); };
  const Samples samples = sample(step, 3000, 2, 16);
  RbfOptions options;
  options.max_sites = 200;
  const RbfInterpolant greedy = fit(samples, options);
  Samples subset = samples;  // random sites, as many
  subset.sites.resize(200);
  subset.values.resize(200);
  const RbfInterpolant uniform = fit(subset, options);
  double worst = 0.0;
  for (std::size_t i = 0; i < samples.sites.size(); ++i) {
    worst = std::max(worst, std::abs(uniform.evaluate(samples.sites[i]) - samples.values[i]));
  }
  REQUIRE(greedy.residual() < 0.3 * worst);
}

TEST_CASE("OrderOfSitesMattersForRoundingOnly") {
  const Samples samples = sample(wave, 300, 2, 17);
  Samples reversed = samples;
  std::reverse(reversed.sites.begin(), reversed.sites.end());
  std::reverse(reversed.values.begin(), reversed.values.end());
  for (const std::uint32_t cap : {300u, 150u}) {
    RbfOptions options;
    options.max_sites = cap;
    const RbfInterpolant s = fit(samples, options);
    const RbfInterpolant t = fit(reversed, options);
    REQUIRE(s.evaluate({0.1, 0.2, 0}) == Approx(t.evaluate({0.1, 0.2, 0})).margin(1e-9));
  }
}

TEST_CASE("SameSitesGiveTheSameBits") {
  const Samples samples = sample(wave, 900, 2, 18);
  RbfOptions options;
  options.max_sites = 400;
  const RbfInterpolant s = fit(samples, options);
  const RbfInterpolant t = fit(samples, options);
  for (const Vec3 x : sample(wave, 30, 2, 19).sites) REQUIRE(s.evaluate(x) == t.evaluate(x));
}

TEST_CASE("DuplicatedSitesCountOnceWithTheirMean") {
  Samples samples = sample(wave, 100, 2, 20);
  const RbfInterpolant once = fit(samples, {});
  Samples doubled = samples;
  doubled.sites.insert(doubled.sites.end(), samples.sites.begin(), samples.sites.end());
  doubled.values.insert(doubled.values.end(), samples.values.begin(), samples.values.end());
  const RbfInterpolant twice = fit(doubled, {});
  REQUIRE(twice.valid());
  REQUIRE(twice.sites() == 100);
  REQUIRE(twice.evaluate({0.3, 0.4, 0}) == once.evaluate({0.3, 0.4, 0}));

  // Values that contradict each other show in the residual.
  samples.sites.push_back(samples.sites[5]);
  samples.values.push_back(samples.values[5] + 1.0);
  const RbfInterpolant torn = fit(samples, {});
  REQUIRE(torn.valid());
  REQUIRE(torn.residual() == Approx(0.5));
  REQUIRE(torn.evaluate(samples.sites[5]) == Approx(samples.values[5] + 0.5));
}

TEST_CASE("SingularInputIsRefused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Form& form : all_forms()) {
    INFO(form.name);
    const RbfOptions options = options_of(form);
    REQUIRE_FALSE(fit({}, options).valid());
    REQUIRE_FALSE(fit(sample(wave, 2, form.dimension, 21), options).valid());
    REQUIRE_FALSE(
        fit({std::vector<Vec3>(50, Vec3{1, 2, 3}), std::vector<double>(50, 1.0)}, options).valid());
    Samples line;
    for (int i = 0; i < 30; ++i) {
      line.sites.push_back({0.1 * i + 7, 0.3 * i - 2, 0.2 * i});
      line.values.push_back(i % 3);
    }
    REQUIRE_FALSE(fit(line, options).valid());
    Samples broken = sample(wave, 60, form.dimension, 22);
    broken.values[30] = nan;
    REQUIRE_FALSE(fit(broken, options).valid());
    broken.values[30] = 0.0;
    broken.sites[31].y = nan;
    REQUIRE_FALSE(fit(broken, options).valid());
    broken.sites[31].y = std::numeric_limits<double>::infinity();
    REQUIRE_FALSE(fit(broken, options).valid());
  }
  // A circle determines no quadratic polynomial.
  Samples circle;
  for (int i = 0; i < 40; ++i) {
    circle.sites.push_back({std::cos(0.157 * i), std::sin(0.157 * i), 0.0});
    circle.values.push_back(0.0);
  }
  RbfOptions triharmonic;
  triharmonic.kernel = RbfKernel::kTriharmonic;
  REQUIRE_FALSE(fit(circle, triharmonic).valid());
  REQUIRE(fit(circle, {}).valid());
}

TEST_CASE("SitesThatNearlyCoincideNeverGiveNonsense") {
  for (const Form& form : all_forms()) {
    for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
      INFO(form.name << ", gap " << gap);
      Samples samples = sample(wave, 100, form.dimension, 23);
      samples.sites.push_back(samples.sites[40] + Vec3{gap, 0, 0});
      samples.values.push_back(wave(samples.sites.back()));
      const RbfInterpolant s = fit(samples, options_of(form));
      if (!s.valid()) continue;
      REQUIRE(s.residual() < 1e-3);
      REQUIRE(std::abs(s.evaluate({0.1, 0.1, 0.0})) < 2.0);
    }
  }
}

TEST_CASE("SmoothingRemovesNoiseAndKeepsExactSites") {
  for (const RbfKernel kernel : {RbfKernel::kBiharmonic, RbfKernel::kTriharmonic}) {
    Samples samples = sample(wave, 1000, 2, 24);
    Random random(25);
    for (double& value : samples.values) value += 0.1 * random.bell();
    RbfOptions options;
    options.kernel = kernel;
    const RbfInterpolant rough = fit(samples, options);
    options.site_spacing = 2.0 / std::sqrt(1000.0);
    options.smoothing_length = 1.5 * options.site_spacing;
    options.exact_sites = 10;
    const RbfInterpolant smooth = fit(samples, options);
    REQUIRE(smooth.valid());
    double rough_sum = 0.0;
    double smooth_sum = 0.0;
    for (const Vec3 x : sample(wave, 300, 2, 26).sites) {
      rough_sum += std::abs(rough.evaluate(0.8 * x) - wave(0.8 * x));
      smooth_sum += std::abs(smooth.evaluate(0.8 * x) - wave(0.8 * x));
    }
    REQUIRE(smooth_sum < 0.6 * rough_sum);
    for (std::size_t i = 0; i < 10; ++i) {
      REQUIRE(smooth.evaluate(samples.sites[i]) == Approx(samples.values[i]).margin(1e-8));
    }
    REQUIRE(smooth.residual() > 0.02);
  }
}

}  // namespace
}  // namespace orbweave
