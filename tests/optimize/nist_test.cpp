// NIST StRD nonlinear regression (https://www.itl.nist.gov/div898/strd, public domain): data, starts and certified
// values are read from NIST's own files; only the 27 model equations stand here. In Roszman1.dat the certified b1 reads
// 2.0196866396E-01 as NIST publishes it.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

#include "simgap/optimize/least_squares.h"
#include "support/files.h"

namespace simgap::test {
namespace {

constexpr int kMost = 9;
using Jet = ceres::Jet<double, kMost>;

struct Problem {
  std::array<std::vector<double>, 2> starts;
  std::vector<double> certified;
  double sum_of_squares = 0.0;
  std::vector<double> y;
  std::vector<std::array<double, 2>> x;
};

Problem readProblem(const std::string& name) {
  Problem problem;
  std::istringstream file(readText(sourceFile("tests/optimize/nist/" + name + ".dat")));
  std::string line;
  int headers = 0;  // the word Data: stands above the description and above the numbers
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string first, equals;
    if (line.rfind("Data:", 0) == 0) {
      ++headers;
    } else if (headers == 2) {
      double y = 0.0, a = 0.0, b = 0.0;
      if (words >> y >> a) {
        words >> b;
        problem.y.push_back(y);
        problem.x.push_back({a, b});
      }
    } else if (line.rfind("Residual Sum of Squares:", 0) == 0) {
      problem.sum_of_squares = std::stod(line.substr(24));
    } else if (words >> first >> equals && first[0] == 'b' && equals == "=") {
      double one = 0.0, two = 0.0, value = 0.0;
      words >> one >> two >> value;
      problem.starts[0].push_back(one);
      problem.starts[1].push_back(two);
      problem.certified.push_back(value);
    }
  }
  return problem;
}

/// The model of a problem at x, as NIST writes it.
template <typename T>
T model(const std::string& name, const T* b, const std::array<double, 2>& at) {
  using std::atan, std::cos, std::exp, std::log, std::pow, std::sin;
  const double x = at[0], pi = std::numbers::pi;
  if (name == "Bennett5") return b[0] * pow(b[1] + x, -1.0 / b[2]);
  if (name == "BoxBOD" || name == "Misra1a") return b[0] * (1.0 - exp(-b[1] * x));
  if (name == "Chwirut1" || name == "Chwirut2") return exp(-b[0] * x) / (b[1] + b[2] * x);
  if (name == "DanWood") return b[0] * pow(T(x), b[1]);
  if (name == "Eckerle4") return b[0] / b[1] * exp(-0.5 * (x - b[2]) * (x - b[2]) / (b[1] * b[1]));
  if (name == "ENSO") {
    const double w = 2.0 * pi * x;
    return b[0] + b[1] * cos(w / 12.0) + b[2] * sin(w / 12.0) + b[4] * cos(w / b[3]) + b[5] * sin(w / b[3]) +
           b[7] * cos(w / b[6]) + b[8] * sin(w / b[6]);
  }
  if (name.starts_with("Gauss")) {
    return b[0] * exp(-b[1] * x) + b[2] * exp(-(x - b[3]) * (x - b[3]) / (b[4] * b[4])) +
           b[5] * exp(-(x - b[6]) * (x - b[6]) / (b[7] * b[7]));
  }
  if (name == "Hahn1" || name == "Thurber") {
    return (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) / (1.0 + x * (b[4] + x * (b[5] + x * b[6])));
  }
  if (name == "Kirby2") return (b[0] + x * (b[1] + x * b[2])) / (1.0 + x * (b[3] + x * b[4]));
  if (name.starts_with("Lanczos")) return b[0] * exp(-b[1] * x) + b[2] * exp(-b[3] * x) + b[4] * exp(-b[5] * x);
  if (name == "MGH09") return b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]);
  if (name == "MGH10") return b[0] * exp(b[1] / (x + b[2]));
  if (name == "MGH17") return b[0] + b[1] * exp(-x * b[3]) + b[2] * exp(-x * b[4]);
  if (name == "Misra1b") return b[0] * (1.0 - 1.0 / ((1.0 + b[1] * x / 2.0) * (1.0 + b[1] * x / 2.0)));
  if (name == "Misra1c") return b[0] * (1.0 - pow(1.0 + 2.0 * b[1] * x, -0.5));
  if (name == "Misra1d") return b[0] * b[1] * x / (1.0 + b[1] * x);
  if (name == "Nelson") return b[0] - b[1] * x * exp(-b[2] * at[1]);
  if (name == "Rat42") return b[0] / (1.0 + exp(b[1] - b[2] * x));
  if (name == "Rat43") return b[0] / pow(1.0 + exp(b[1] - b[2] * x), 1.0 / b[3]);
  if (name == "Roszman1") return b[0] - b[1] * x - atan(b[2] / (x - b[3])) / pi;
  ADD_FAILURE() << "no model for " << name;
  return b[0];
}

LeastSquaresProblem leastSquares(const std::string& name, const Problem& data) {
  LeastSquaresProblem problem;
  for (std::size_t i = 0; i < data.certified.size(); ++i)
    problem.parameters.push_back({"b" + std::to_string(i + 1), "1"});
  problem.chunks = evenChunks(data.y.size());
  problem.evaluate = [&data, name](std::span<const double> theta, const Block& rows, Eigen::Ref<Eigen::VectorXd> r,
                                   Eigen::Ref<Eigen::MatrixXd>* jacobian) {
    std::array<Jet, kMost> b;
    for (std::size_t j = 0; j < theta.size(); ++j) b[j] = Jet(theta[j], static_cast<int>(j));
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      const double y = name == "Nelson" ? std::log(data.y[i]) : data.y[i];
      const Jet f = model(name, b.data(), data.x[i]) - y;
      const auto row = static_cast<Eigen::Index>(i - rows.begin);
      r[row] = f.a;
      if (jacobian != nullptr) jacobian->row(row) = f.v.head(theta.size()).transpose();
    }
  };
  return problem;
}

/// Correct digits of the worst parameter.
double digits(const std::vector<double>& found, const std::vector<double>& certified) {
  double worst = 1.0e-11;
  for (std::size_t i = 0; i < found.size(); ++i) {
    worst = std::max(worst, std::abs(found[i] - certified[i]) / std::abs(certified[i]));
  }
  return -std::log10(worst);
}

class NistTest : public testing::TestWithParam<const char*> {};

TEST_P(NistTest, BothStartsReachTheCertifiedValues) {
  const Problem data = readProblem(GetParam());
  ASSERT_FALSE(data.certified.empty());
  ASSERT_FALSE(data.y.empty());
  const LeastSquaresProblem problem = leastSquares(GetParam(), data);
  LeastSquaresOptions options;
  options.max_iterations = 20000;
  options.function_tolerance = 1e-18;
  options.parameter_tolerance = 1e-15;
  options.radii = {1e4, 1.0, 1e-2, 1e-4};
  for (const std::vector<double>& start : data.starts) {
    const LeastSquaresResult result = minimise(problem, start, options);
    EXPECT_GE(digits(result.theta, data.certified), 6.0)
        << testing::PrintToString(result.theta) << " after " << result.iterations << " iterations: " << result.message;
    if (data.sum_of_squares > 1e-20) {
      EXPECT_NEAR(result.cost / data.sum_of_squares, 1.0, 1e-6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(StRD, NistTest,
                         testing::Values("Bennett5", "BoxBOD", "Chwirut1", "Chwirut2", "DanWood", "ENSO", "Eckerle4",
                                         "Gauss1", "Gauss2", "Gauss3", "Hahn1", "Kirby2", "Lanczos1", "Lanczos2",
                                         "Lanczos3", "MGH09", "MGH10", "MGH17", "Misra1a", "Misra1b", "Misra1c",
                                         "Misra1d", "Nelson", "Rat42", "Rat43", "Roszman1", "Thurber"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace simgap::test
