// Trees on the table of a screening design in five groups.
#include <gtest/gtest.h>

#include "grouped_screening.hpp"
#include "repose/surrogate/bagged_trees.hpp"
#include "repose/surrogate/boosted_trees.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace repose::surrogate {
namespace {

using test::grouped_screening;

TEST(GroupedScreening, HasTheShapeOfItsModel) {
  const auto table = grouped_screening(1);
  EXPECT_EQ(table.data.rows(), 185);
  EXPECT_EQ(table.data.dimension(), 18);
  EXPECT_NO_THROW(check(table.data));
  // noise of 0.01 in 185 rows, four standard errors
  const double noise = std::sqrt((table.data.y - table.expected).squaredNorm() / 185.0);
  EXPECT_NEAR(noise, 0.01, 4.0 * 0.01 / std::sqrt(2.0 * 185.0));
}

// a mean predicts with an error of 0.168; what is held against them is that they explain most of it
TEST(Ensembles, ExplainMostOfAScreeningTableInCrossValidation) {
  const auto table = grouped_screening(2);
  const auto folds = k_folds(table.data, {.folds = 10, .seed = 3});
  const auto r2 = [&](const Trainer& trainer) {
    return cross_validate(table.data, trainer, folds).metrics.r2;
  };
  EXPECT_GT(r2(bagged_trees_trainer("bag")), 0.9);
  EXPECT_GT(r2(boosted_trees_trainer("boosting")), 0.95);
  EXPECT_GT(r2(tree_trainer("tree")), 0.6);
}

TEST(Ensembles, RankTheInputsThatMatterFirst) {
  const auto table = grouped_screening(4);
  const auto bag = BaggedTrees::fit(table.data);
  const auto importance = bag.importance(table.data);
  for (const std::size_t active : {0u, 1u, 2u, 16u})
    for (std::size_t k = 6; k < 15; ++k)  // x7 ... x15 have no effect
      EXPECT_GT(importance[active].increase, 5.0 * importance[k].increase) << active << " " << k;
}

TEST(Ensembles, KnowMoreOfAGroupThatTheyHaveSeen) {
  const auto table = grouped_screening(5);
  const auto seen = k_folds(table.data, {.folds = 5, .seed = 1});
  const auto unseen = leave_group_out(table.data);
  const Trainer trainer = boosted_trees_trainer("boosting");
  EXPECT_LT(2.0 * cross_validate(table.data, trainer, seen).metrics.rmse,
            cross_validate(table.data, trainer, unseen).metrics.rmse);
}

}  // namespace
}  // namespace repose::surrogate
