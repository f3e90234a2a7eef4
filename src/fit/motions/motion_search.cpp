#include "simgap/fit/motions/motion_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr double kFirstStep = 0.1;  // of differences, in prior standard deviations
constexpr double kSmallestStep = 0.005, kLargestStep = 0.3;
constexpr double kDrowned = 0.5;  // noise in what is told of a parameter beside all others
constexpr double kLonger = 3.0, kLongestStep = 1.0;
constexpr double kTelling = 2.0;    // information in the prior's, of a direction that is worth new derivatives
constexpr double kMoveTimes = 5.0;  // step along it, in standard deviations of what is known: above stick and slip
constexpr double kLeastMove = 0.3;  // of that step, that bounds leave
constexpr int kMostSteps = 6;       // with one set of derivatives
constexpr double kEnough = 0.05;    // of the gain promised: below it the derivatives are too old
constexpr double kLittle = 3e-4;    // of the objective: a round that gains less was the last
constexpr double kCertain = 0.5;    // [negative log posterior] as well
constexpr double kMostDamping = 1e6;
constexpr double kMostOfNoise = 1.645;                  // what nine of ten normal residuals stay within [sd]
constexpr std::array kHorizons{0.125, 0.25, 0.5, 1.0};  // of rounds; the last of all that follow
constexpr float kFallen = 100.0F;                       // ratio of the squares of differences forwards and backwards

/// J += (dr - J dz) dz^T / |dz|^2
void learnFromStep(MotionLinearisation& here, const Eigen::VectorXd& step, const MotionEvaluation& there) {
  const Eigen::VectorXf direction = (step / step.squaredNorm()).cast<float>();
  for (std::size_t m = 0; m < here.jacobians.size(); ++m) {
    RowMajorF& jacobian = here.jacobians[m];
    const Eigen::VectorXf surprise =
        (there.residuals[m] - here.at.residuals[m]).cast<float>() - jacobian * step.cast<float>();
    jacobian.noalias() += surprise * direction.transpose();
  }
}

/// Moves of z along the eigenvectors of what motions tell, those that they tell more of than the prior, within the
/// bounds. \returns shape (size, moves)
Eigen::MatrixXd tellingMoves(const MotionPosterior& posterior, const MotionLinearisation& here) {
  Eigen::MatrixXd information = posterior.normalEquations(here.z, here.at, here.jacobians).curvature;
  for (Eigen::Index i = 0; i < information.rows(); ++i) information(i, i) -= posterior.hasPrior(i) ? 1.0 : 0.0;
  const SymmetricEigen told = symmetricEigen(information);
  Eigen::MatrixXd moves(information.rows(), information.cols());
  Eigen::Index count = 0;
  for (Eigen::Index k = told.values.size() - 1; k >= 0 && told.values[k] > kTelling; --k) {
    const double step = std::clamp(kMoveTimes / std::sqrt(told.values[k]), kSmallestStep, kLargestStep);
    Eigen::VectorXd best = Eigen::VectorXd::Zero(here.z.size());
    for (const double side : {step, -step}) {
      Eigen::VectorXd move = side * told.vectors.col(k);
      for (Eigen::Index i = 0; i < move.size(); ++i) {
        move[i] = std::clamp(here.z[i] + move[i], posterior.lower(i), posterior.upper(i)) - here.z[i];
      }
      if (move.squaredNorm() > (1.0 + 1e-9) * best.squaredNorm()) best = move;
    }
    if (best.norm() > kLeastMove * step) moves.col(count++) = best;
  }
  return moves.leftCols(count);
}

/// Marquardt's step within the bounds: what would leave them is held there, and the rest solved again.
Eigen::VectorXd dampedStep(const MotionPosterior& posterior, const MotionPosterior::NormalEquations& normal,
                           const Eigen::VectorXd& z, double damping) {
  Eigen::MatrixXd curvature = normal.curvature;
  curvature.diagonal() *= 1.0 + damping;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(z.size());  // of those that are held
  std::vector<Eigen::Index> free(static_cast<std::size_t>(z.size()));
  std::iota(free.begin(), free.end(), 0);
  while (true) {
    const Eigen::VectorXd rest = normal.gradient + curvature * step;
    const Eigen::VectorXd solved = -curvature(free, free).llt().solve(rest(free));
    std::vector<Eigen::Index> still_free;
    for (std::size_t k = 0; k < free.size(); ++k) {
      const Eigen::Index i = free[k];
      const double to = std::clamp(z[i] + solved[k], posterior.lower(i), posterior.upper(i));
      if (to == z[i] + solved[k]) {
        still_free.push_back(i);
      } else {
        step[i] = to - z[i];
      }
    }
    if (still_free.size() == free.size()) {
      step(free) = solved;
      return step;
    }
    free = std::move(still_free);
  }
}

/// What the quadratic model promises of a step.
double promised(const MotionPosterior::NormalEquations& normal, const Eigen::VectorXd& step) {
  return -(normal.gradient.dot(step) + 0.5 * step.dot(normal.curvature * step));
}

Eigen::MatrixXd covarianceOf(const MotionPosterior::NormalEquations& normal) {
  const Eigen::Index n = normal.gradient.size();
  return normal.curvature.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
}

/// Differences over about a standard deviation of what will be known: shorter ones drown in stick and slip, longer
/// ones are bent.
Eigen::VectorXd differenceSteps(const Eigen::MatrixXd& covariance) {
  return covariance.diagonal().cwiseMax(0.0).cwiseSqrt().cwiseMax(kSmallestStep).cwiseMin(kLargestStep);
}

/// Derivatives from both sides of a place, over whole and over half steps, of one motion.
struct Differences {
  RowMajorF& forward;
  const RowMajorF &backward, &half_forward, &half_backward;
};

/// Squares of the noise of central differences, summed over a motion's residuals as they are weighed. Where one side is
/// much larger the arm fell into another rest there: the other side is taken.
///
/// Stick and slip make residuals jump wherever a parameter crosses a threshold of theirs. Jumps whose squares sum to
/// rho over a unit of the parameter leave rho / (2 h) in the square of (r(h) - r(-h)) / (2 h), and 10 h rho in that of
///
///     c = r(h) - 4 r(h/2) + 6 r(0) - 4 r(-h/2) + r(-h) = h ((forward - backward) - 2 (half_forward - half_backward)),
///
/// in which a response that is smooth, however bent, leaves only its fourth derivative: the noise is c^2 / (20 h^2).
/// \param[in,out] d  its forward differences become the means
Eigen::VectorXd meanWithNoise(const Eigen::VectorXf& weights, Differences d) {
  Eigen::VectorXd noise = Eigen::VectorXd::Zero(d.forward.cols());
  for (Eigen::Index i = 0; i < noise.size(); ++i) {
    const float ahead = d.forward.col(i).cwiseAbs2().dot(weights), back = d.backward.col(i).cwiseAbs2().dot(weights);
    if (std::max(ahead, back) > kFallen * std::min(ahead, back)) {
      if (back < ahead) d.forward.col(i) = d.backward.col(i);
      continue;
    }
    const Eigen::VectorXf difference = d.forward.col(i) - d.backward.col(i);
    if (difference.isZero(0.0F)) continue;  // beside a bound both stand on one side
    const Eigen::VectorXf jumps = difference - 2.0F * (d.half_forward.col(i) - d.half_backward.col(i));
    noise[i] = static_cast<double>(jumps.cwiseAbs2().dot(weights)) / 20.0;
    d.forward.col(i) -= 0.5F * difference;
  }
  return noise;
}

/// What motions tell by derivatives in which there is noise, measured J = G + E: E[J^T J] = G^T G + diag(noise).
struct ToldThroughNoise {
  Eigen::MatrixXd covariance;  ///< inverse of prior and G^T G
  Eigen::MatrixXd cleaning;    ///< J times it is the best linear estimate of G
};

/// Information that noise would make negative is none. G is told by J as a signal by its noisy measurement (Wiener):
///
///     K = G^T G = J^T J - diag(noise),        E[G | J] = J (K + diag(noise))^-1 K
ToldThroughNoise toldThrough(const Eigen::VectorXd& noise, const MotionPosterior& posterior,
                             const MotionPosterior::NormalEquations& normal) {
  const Eigen::Index n = noise.size();
  Eigen::MatrixXd information = normal.curvature;
  Eigen::VectorXd prior = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) prior[i] = posterior.hasPrior(i) ? 1.0 : 0.0;
  information.diagonal() -= prior;
  const Eigen::VectorXd left_out = noise.cwiseMin(information.diagonal());
  information.diagonal() -= left_out;
  const SymmetricEigen told = symmetricEigen(information);
  const Eigen::VectorXd kept = told.values.cwiseMax(1e-12 * told.values.maxCoeff());
  information = told.vectors * kept.asDiagonal() * told.vectors.transpose();
  Eigen::MatrixXd measured = information, curvature = information;
  measured.diagonal() += left_out;
  curvature.diagonal() += prior;
  return {curvature.ldlt().solve(Eigen::MatrixXd::Identity(n, n)), measured.ldlt().solve(information)};
}

/// Share of every motion that a round compares; all where too few rounds may follow. \param rounds  before it
double horizonOf(int rounds, int max_rounds) {
  constexpr int kCount = static_cast<int>(kHorizons.size());
  return max_rounds < kCount ? 1.0 : kHorizons[static_cast<std::size_t>(std::min(rounds, kCount - 1))];
}

/// Derivatives from both sides, of the parameters that have a step. \param[in,out] here  with those forwards, which
/// become the means  \returns the squares of their noise
Eigen::VectorXd differenceBothWays(const MotionPosterior& posterior, MotionLinearisation& here,
                                   const Eigen::VectorXd& steps,
                                   const std::function<void(const MotionSearchNews&)>& news) {
  const std::size_t played = static_cast<std::size_t>((steps.array() != 0.0).count()) * posterior.motions().size();
  std::vector<std::vector<RowMajorF>> others;
  for (const double part : {-1.0, 0.5, -0.5}) {
    const std::size_t before = others.size() * played;
    others.push_back(posterior.jacobian(here.z, part * steps, here.at, [&](std::size_t done) {
      if (news) news({before + done, 3 * played});
    }));
    if (interruptRequested()) throw InterruptedError("interrupted");
  }
  Eigen::VectorXd noise = Eigen::VectorXd::Zero(posterior.size());
  for (std::size_t m = 0; m < here.jacobians.size(); ++m) {
    const Eigen::VectorXf weights = posterior.weights(m, here.at.residuals[m]).cast<float>();
    noise += meanWithNoise(weights, {here.jacobians[m], others[0][m], others[1][m], others[2][m]});
  }
  return noise;
}

/// Diagonal of J^T W J: information, and noise that passes for it.
Eigen::VectorXd squaresOf(const MotionPosterior& posterior, const MotionPosterior::NormalEquations& normal) {
  Eigen::VectorXd squares = normal.curvature.diagonal();
  for (Eigen::Index i = 0; i < squares.size(); ++i) squares[i] -= posterior.hasPrior(i) ? 1.0 : 0.0;
  return squares;
}

/// Noise falls with a step's length (meanWithNoise): where it drowns what is told of a parameter beside all others,
/// derivatives are made once more over longer steps, and the clearer ones kept. \param[in,out] here, noise  as
/// differenceBothWays leaves them
void clearDrowned(const MotionPosterior& posterior, MotionLinearisation& here, Eigen::VectorXd& noise,
                  const Eigen::VectorXd& steps, const std::function<void(const MotionSearchNews&)>& news) {
  const auto normal = posterior.normalEquations(here.z, here.at, here.jacobians);
  const Eigen::VectorXd squares = squaresOf(posterior, normal), variance = covarianceOf(normal).diagonal();
  Eigen::VectorXd longer = Eigen::VectorXd::Zero(steps.size());
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    if (noise[i] * variance[i] > kDrowned) longer[i] = std::min(kLonger * steps[i], kLongestStep);
  }
  if (longer.isZero(0.0)) return;
  MotionLinearisation there{here.z, here.at, posterior.jacobian(here.z, longer, here.at)};
  const Eigen::VectorXd noise_there = differenceBothWays(posterior, there, longer, news);
  const Eigen::VectorXd squares_there =
      squaresOf(posterior, posterior.normalEquations(there.z, there.at, there.jacobians));
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    if (longer[i] == 0.0 || !(noise_there[i] * squares[i] < noise[i] * squares_there[i])) continue;
    noise[i] = noise_there[i];
    for (std::size_t m = 0; m < here.jacobians.size(); ++m) here.jacobians[m].col(i) = there.jacobians[m].col(i);
  }
}

/// The end of a search: derivatives from both sides. \param here  with those forwards
MotionFit finalFit(const MotionPosterior& posterior, MotionLinearisation here, const Eigen::VectorXd& steps,
                   const std::function<void(const MotionSearchNews&)>& news) {
  Eigen::VectorXd noise = differenceBothWays(posterior, here, steps, news);
  clearDrowned(posterior, here, noise, steps, news);
  const auto normal = posterior.normalEquations(here.z, here.at, here.jacobians);
  const Eigen::VectorXd left = dampedStep(posterior, normal, here.z, 0.0);
  const double from_optimum = std::sqrt(std::max(0.0, 2.0 * promised(normal, left)));
  ToldThroughNoise told = toldThrough(noise, posterior, normal);
  for (RowMajorF& jacobian : here.jacobians) {
    jacobian = (jacobian.cast<double>() * told.cleaning).cast<float>().eval();
  }
  return {here.z, here.at.objective, std::move(told.covariance), std::move(here.jacobians), left, from_optimum};
}

}  // namespace

MotionLinearisation linearise(const MotionPosterior& posterior, const Eigen::VectorXd& z, const Eigen::VectorXd& steps,
                              const std::function<void(const MotionSearchNews&)>& news) {
  MotionLinearisation here{z, posterior.evaluate(z), {}};
  if (interruptRequested()) throw InterruptedError("interrupted");
  if (!here.at.valid) throw NumericsError("the motions cannot be played with these parameters");
  const std::size_t of = static_cast<std::size_t>(posterior.size()) * posterior.motions().size();
  here.jacobians = posterior.jacobian(z, steps, here.at, [&](std::size_t done) {
    if (news) news({done, of});
  });
  if (interruptRequested()) throw InterruptedError("interrupted");
  return here;
}

long renew(const MotionPosterior& posterior, MotionLinearisation& here,
           const std::function<void(const MotionSearchNews&)>& news) {
  const Eigen::MatrixXd moves = tellingMoves(posterior, here);
  if (moves.cols() == 0) return 0;
  const std::size_t of = static_cast<std::size_t>(moves.cols()) * posterior.motions().size();
  std::vector<RowMajorF> changes = posterior.changes(here.z, moves, here.at, [&](std::size_t done) {
    if (news) news({done, of});
  });
  if (interruptRequested()) throw InterruptedError("interrupted");
  Eigen::MatrixXd gram = moves.transpose() * moves;
  gram.diagonal() *= 1.0 + 1e-9;  // moves that bounds have cut short may fall together
  const RowMajorF learnt = gram.llt().solve(moves.transpose()).cast<float>(), way = moves.cast<float>();
  for (std::size_t m = 0; m < changes.size(); ++m) {
    RowMajorF& surprise = changes[m];
    surprise -= here.jacobians[m] * way;
    for (Eigen::Index k = 0; k < surprise.cols(); ++k) {
      if (std::isnan(surprise(0, k))) surprise.col(k).setZero();  // it could not be played: nothing is learnt
    }
    here.jacobians[m] += surprise * learnt;
  }
  return static_cast<long>(of);
}

int descend(const MotionPosterior& posterior, MotionLinearisation& here, double& damping, long& rollouts) {
  int accepted = 0;
  for (int i = 0; i < kMostSteps && damping < kMostDamping; ++i) {
    const auto normal = posterior.normalEquations(here.z, here.at, here.jacobians);
    const Eigen::VectorXd step = dampedStep(posterior, normal, here.z, damping);
    const double promise = promised(normal, step);
    if (!(promise > kCertain * 0.1)) break;
    const MotionEvaluation there = posterior.evaluate(here.z + step);
    rollouts += std::ssize(posterior.motions());
    if (interruptRequested()) throw InterruptedError("interrupted");
    const double gain = here.at.objective - there.objective;
    if (there.valid) learnFromStep(here, step, there);
    if (gain > 0.0) {
      ++accepted;
      std::vector<PoseResidual> poses = std::move(here.at.poses);  // with their derivatives, which are kept as well
      here.z += step;
      here.at = there;
      for (std::size_t p = 0; p < poses.size(); ++p) here.at.poses[p].jacobian = std::move(poses[p].jacobian);
    }
    damping = gain > 0.5 * promise ? std::max(1e-6, 0.2 * damping) : gain > 0.0 ? damping : 5.0 * damping;
    if (gain > 0.0 && gain < kEnough * promise) break;
    if (gain > 0.0 && gain < kLittle * here.at.objective) break;
  }
  return accepted;
}

Eigen::MatrixXd covarianceAt(const MotionPosterior& posterior, const MotionLinearisation& here) {
  return covarianceOf(posterior.normalEquations(here.z, here.at, here.jacobians));
}

Eigen::VectorXd stepLeftAt(const MotionPosterior& posterior, const MotionLinearisation& here) {
  return dampedStep(posterior, posterior.normalEquations(here.z, here.at, here.jacobians), here.z, 0.0);
}

void fitRobustScale(MotionPosterior& posterior, const Eigen::VectorXd& z, MotionEvaluation& at) {
  std::vector<double> squares;
  for (std::size_t m = 0; m < at.residuals.size(); ++m) {
    for (const ResidualBlock& block : posterior.motions()[m].blocks()) {
      if (!posterior.counts(m, block)) continue;
      squares.push_back(at.residuals[m].segment(block.first, block.size).squaredNorm() /
                        static_cast<double>(block.size));
    }
  }
  const double most = std::sqrt(quantile(std::move(squares), 0.9));
  posterior.setRobustScale(kRobustScale * std::max(1.0, most / kMostOfNoise));
  at.objective = posterior.objectiveOf(at, z);
}

MotionSearchState beginSearch(const MotionPosterior& posterior) {
  MotionSearchState state;
  state.z = Eigen::VectorXd::Zero(posterior.size());
  state.steps = Eigen::VectorXd::Constant(posterior.size(), kFirstStep);
  return state;
}

MotionFit fitAt(const MotionPosterior& posterior, const Eigen::VectorXd& z, const Eigen::VectorXd& steps,
                const std::function<void(const MotionSearchNews&)>& news) {
  return finalFit(posterior, linearise(posterior, z, steps, news), steps, news);
}

MotionFit searchMotions(MotionPosterior& posterior, MotionSearchState& state, int max_rounds,
                        const std::function<void(const MotionSearchNews&)>& news,
                        const std::function<void(const MotionSearchState&)>& after_round) {
  using Clock = std::chrono::steady_clock;
  while (true) {
    const auto start = Clock::now();
    const int rounds = static_cast<int>(state.history.size());
    const bool at_end = state.converged || rounds == max_rounds;
    const double horizon = at_end ? 1.0 : horizonOf(rounds, max_rounds);
    posterior.setHorizon(horizon);
    MotionLinearisation here = linearise(posterior, state.z, state.steps, news);
    fitRobustScale(posterior, state.z, here.at);
    if (at_end) return finalFit(posterior, std::move(here), state.steps, news);
    MotionRound round{rounds + 1, here.at.objective, here.at.objective, 0, 0, 0.0, horizon};
    round.rollouts =
        (rounds == 0 ? 0 : state.history.back().rollouts) + (posterior.size() + 1) * std::ssize(posterior.motions());
    MotionLinearisation trial = here;
    round.steps = descend(posterior, trial, state.damping, round.rollouts);
    round.after = trial.at.objective;
    state.converged = horizon == 1.0 && round.before - round.after < std::max(kCertain, kLittle * round.after);
    const auto normal = posterior.normalEquations(here.z, here.at, here.jacobians);
    round.expected = std::max(0.0, promised(normal, dampedStep(posterior, normal, here.z, 0.0)));
    if (!state.converged) {  // else the fresh derivatives stay those of what is kept
      state.z = trial.z;
      state.steps = differenceSteps(covarianceOf(normal));
    }
    state.history.push_back(round);
    state.wall += std::chrono::duration<double>(Clock::now() - start).count();
    after_round(state);
    if (state.converged) return finalFit(posterior, std::move(here), state.steps, news);
  }
}

}  // namespace simgap
