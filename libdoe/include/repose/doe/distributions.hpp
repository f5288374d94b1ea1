// Tail probabilities of the tests, accurate far into the tail.
#pragma once

namespace repose::doe {

/// P(F > f) for Fisher's F with (df1, df2) degrees of freedom; relative error below 1e-12 down to
/// 1e-300. 1 for f <= 0, 0 for f = infinity, NaN if f is NaN or a df is not positive.
double f_upper_tail(double f, double df1, double df2);

/// P(|T| > |t|) for Student's t; relative error as above. NaN if t is NaN or df is not positive.
double t_two_sided(double t, double df);

}  // namespace repose::doe
