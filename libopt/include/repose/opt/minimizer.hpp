// Minimises a function inside a box or a feasible set: the library's methods behind one door, and
// a door for the user's own.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>

#include "repose/opt/feasible_set.hpp"

namespace repose::opt {

/// Local with gradient: lbfgs (projected, ours), slsqp. Local without: bobyqa. Global without:
/// crs2, direct_l, isres. slsqp and isres take linear constraints, all take ties.
enum class Algorithm { lbfgs, slsqp, bobyqa, crs2, direct_l, isres };

/// What follows a method that gives up.
enum class Fallback {
  next_method,  ///< of lbfgs -> slsqp -> bobyqa, while evaluations are left
  none          ///< nothing: slsqp takes O(d^3) a step, bobyqa thousands of steps
};

struct MinimizerOptions {
  Algorithm algorithm = Algorithm::lbfgs;
  /// Stop when |x_new - x| <= relative_x_tolerance |x| + absolute_x_tolerance (upper - lower).
  double relative_x_tolerance = 1e-8;
  double absolute_x_tolerance = 1e-10;
  /// Stop when |f_new - f| <= relative_f_tolerance |f|.
  double relative_f_tolerance = 1e-12;
  /// All evaluations, those of a fallback included. Global methods use all of them; points that
  /// break a constraint are not evaluated, but count here.
  int max_evaluations = 2000;
  /// First step of bobyqa as a fraction of the range; 0: chosen from start and bounds.
  double initial_step = 0.0;
  /// Second derivative that lbfgs assumes where its steps have not told it; 0: that of the newest
  /// step, which takes no notice of units. >= 0.
  double initial_curvature = 0.0;
  Fallback fallback = Fallback::next_method;
  /// Of crs2 and isres.
  std::uint64_t seed = 1;
};

enum class Termination {
  converged,  ///< a tolerance is met
  budget,     ///< evaluations or generations are used up; the best point is still good
  round_off,  ///< the value improved until rounding stopped it
  failed      ///< no finite value was seen
};
const char* to_string(Termination termination);

struct Minimum {
  Vector x;            ///< the best point seen, inside the bounds
  double value = 0.0;  ///< its value; +infinity where none was finite
  Termination termination = Termination::failed;
  std::string message;  ///< one sentence
  int evaluations = 0;
  double seconds = 0.0;
};

/// The smallest value found from `start`, which is first projected onto the bounds. The best point
/// seen is kept whatever the method says in the end. A method that gives up hands its best point to
/// the next as MinimizerOptions::fallback says. Same arguments, same bits.
/// Throws InputError on bad bounds or a start of the wrong length; exceptions of `objective` pass.
Minimum minimize(const Objective& objective, const Vector& start, const Bounds& bounds,
                 const MinimizerOptions& options = {});

/// The same inside a feasible set. A start that breaks constraints is first moved to the nearest
/// point that obeys them; the objective is asked at no point that breaks one by more than rounding
/// (1e-10 of its range), and the best point has violation() == 0. slsqp then has no fallback.
/// Termination::failed with the constraints by name where no point obeys all of them at once.
/// Throws InputError on what check_feasible_set refuses, on inequalities for a method that takes
/// none, and on whole numbers: these want minimize_genetic or minimize_cma_es.
/// `Set` is FeasibleSet by its name: {lower, upper} in braces are Bounds.
template <std::same_as<FeasibleSet> Set>
Minimum minimize(const Objective& objective, const Vector& start, const Set& set,
                 const MinimizerOptions& options = {});

/// Something that minimises: any struct with this one member function.
template <class M>
concept MinimizerLike = requires(const M& m, const Objective& f, const Vector& x, const Bounds& b) {
  { m.minimize(f, x, b) } -> std::convertible_to<Minimum>;
};

/// The default: minimize() above with these options.
struct BuiltinMinimizer {
  MinimizerOptions options = {};
  Minimum minimize(const Objective& objective, const Vector& start, const Bounds& bounds) const {
    return opt::minimize(objective, start, bounds, options);
  }
};

/// Any minimiser as a value.
class Minimizer {
 public:
  Minimizer() : Minimizer(BuiltinMinimizer{}) {}
  template <MinimizerLike M>
  requires(!std::same_as<std::remove_cvref_t<M>, Minimizer>) Minimizer(M method)
      : minimize_([m = std::move(method)](const Objective& f, const Vector& x, const Bounds& b) {
          return Minimum(m.minimize(f, x, b));
        }) {}

  /// Must be safe to call from several threads at once.
  Minimum minimize(const Objective& objective, const Vector& start, const Bounds& bounds) const {
    return minimize_(objective, start, bounds);
  }

 private:
  std::function<Minimum(const Objective&, const Vector&, const Bounds&)> minimize_;
};

/// The best of the minima from every row of `starts` (s x d, s >= 1), the first one of equal value;
/// evaluations are summed. The result does not depend on `threads` (0: one for each processor); the
/// objective is called from several threads at once.
Minimum multi_start(const Objective& objective, const Matrix& starts, const Bounds& bounds,
                    const Minimizer& minimizer = {}, unsigned threads = 1);

/// The same inside a feasible set.
template <std::same_as<FeasibleSet> Set>
Minimum multi_start(const Objective& objective, const Matrix& starts, const Set& set,
                    const MinimizerOptions& options = {}, unsigned threads = 1);

}  // namespace repose::opt
