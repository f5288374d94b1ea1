// Designs for quadratic models: central composite and Box-Behnken.
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

struct CentralCompositeOptions {
  enum class Kind {
    circumscribed,  ///< factorial runs at -1 and 1, axial runs beyond them at -alpha and alpha
    face_centred,   ///< both at -1 and 1
    inscribed,      ///< axial runs at -1 and 1, factorial runs within them
  };
  enum class Alpha {
    rotatable,   ///< alpha^4 = F: the variance of a prediction depends on its distance only
    orthogonal,  ///< alpha^2 = (sqrt(F N) - F)/2: quadratics uncorrelated with each other
  };
  Kind kind = Kind::face_centred;
  /// Unused if face-centred.
  Alpha alpha = Alpha::rotatable;
  /// >= 1; several give pure error.
  int centre_runs = 4;
};

struct CentralComposite {
  Matrix coded;  ///< factorial, axial, then centre runs x factors
  int factorial_runs = 0;
  double alpha = 1.0;  ///< distance of axial runs over that of factorial runs in one factor
};

/// F = 2^factors factorial runs for up to 4 factors, above a fraction of resolution V or more (16
/// for 5, 32 for 6, 64 for 7 and 8, 128 for 9 to 11), 2 factors axial runs and centre runs, N in
/// all [BoxWilson1951], [BoxHunter1957]. `factors` from 2 to 11, centre runs from 1 to 1000. Throws
/// InputError otherwise.
CentralComposite central_composite(int factors, const CentralCompositeOptions& options = {});

/// Incomplete blocks of factors at all combinations of -1 and 1 (half of them for 11 factors), the
/// others at 0, then centre runs [BoxBehnken1960]: 12, 24, 40, 48, 56 runs for 3 to 7 factors, 120,
/// 160, 176, 192 for 9 to 12. `centre_runs` < 0 gives the published number: 3, 3, 6, 6, 6, 10, 10,
/// 12, 12. Throws InputError for other factors or without a centre run.
Matrix box_behnken(int factors, int centre_runs = -1);

}  // namespace repose::doe
