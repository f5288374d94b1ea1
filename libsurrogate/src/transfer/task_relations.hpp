// How a target may relate to a source, before any of the target is known.
#pragma once

#include <vector>

#include "repose/surrogate/coregionalised_process.hpp"

namespace repose::surrogate {

/// The prior of CoregionalisedProcess by 1,024 points of equal weight, which are left open.
/// `noise` is the source's; `else_variance` stands for the variance of a source that is constant.
std::vector<TaskRelation> possible_relations(const GaussianProcess& source, double noise,
                                             double else_variance);

/// n x n, of a target's function at the rows of x before any of them is known, averaged over
/// possible_relations(). O(1024 n^2 d), and four matrices of n x n.
Matrix prior_target_covariance(const GaussianProcess& source, const Matrix& x);

}  // namespace repose::surrogate
