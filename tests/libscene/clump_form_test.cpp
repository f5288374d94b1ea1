#include "repose/scene/clump_form.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::scene {
namespace {

constexpr double kPi = std::numbers::pi;
using Sphere = ClumpShape::Sphere;

TEST(UnionMoments, OfOneSphereAreItsClosedForms) {
  const UnionMoments m = union_moments({{{0.3, -2.0, 1.0}, 0.7}});
  EXPECT_NEAR(m.volume, 4.0 / 3.0 * kPi * 0.343, 1e-13);
  EXPECT_LT((m.centroid - Vec3(0.3, -2.0, 1.0)).norm(), 1e-14);
  const Eigen::Matrix3d expected = m.volume * 0.49 / 5.0 * Eigen::Matrix3d::Identity();
  EXPECT_LT((m.second - expected).norm(), 1e-13);
}

/// Two unit spheres at -s and s along a direction: each contributes a sphere cut at the distance s
/// from its centre, z counted from there and away from the cut.
struct CutSphere {
  double volume, first, second;  // 1, z, z^2 over z > -s in a unit sphere about the origin
  explicit CutSphere(double s)
      : volume(kPi * (2.0 / 3.0 + s - s * s * s / 3.0)),
        first(kPi * (1.0 - s * s) * (1.0 - s * s) / 4.0),
        second(kPi * (2.0 / 15.0 + s * s * s / 3.0 - std::pow(s, 5) / 5.0)) {}
};

TEST(UnionMoments, OfTwoOverlappingSpheresAreTheirClosedForms) {
  for (double s : {0.1, 0.5, 0.9}) {
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(1, 2, -3).normalized()}) {
      const Vec3 at(5, -1, 2);
      const UnionMoments m = union_moments({{at - s * axis, 1.0}, {at + s * axis, 1.0}});
      const CutSphere half(s);
      EXPECT_NEAR(m.volume, 2.0 * half.volume, 1e-12);
      EXPECT_LT((m.centroid - at).norm(), 1e-13);
      // Along the axis: z = z' + s with z' from the sphere's centre.
      const double along = 2.0 * (half.second + 2.0 * s * half.first + s * s * half.volume);
      EXPECT_NEAR(axis.dot(m.second * axis), along, 1e-12);
      // Across: half of x^2 + y^2 = (1 - z'^2)^2/2 pi dz', integrated.
      const auto across_to = [](double z) {
        return kPi / 4.0 * (z - 2.0 * z * z * z / 3.0 + std::pow(z, 5) / 5.0);
      };
      const double across = 2.0 * (across_to(1.0) - across_to(-s));
      EXPECT_NEAR(m.second.trace() - axis.dot(m.second * axis), 2.0 * across, 1e-12);
    }
  }
}

TEST(UnionMoments, OfDisjointNestedAndRepeatedSpheresCountEachPointOnce) {
  const Sphere big{{0, 0, 0}, 1.0};
  const double volume = 4.0 / 3.0 * kPi;
  EXPECT_NEAR(union_moments({big, {{0.2, 0.1, 0}, 0.3}}).volume, volume, 1e-13);
  EXPECT_NEAR(union_moments({{{0.2, 0.1, 0}, 0.3}, big}).volume, volume, 1e-13);
  EXPECT_NEAR(union_moments({big, big, big}).volume, volume, 1e-13);
  EXPECT_NEAR(union_moments({big, {{5, 0, 0}, 2.0}}).volume, 9.0 * volume, 1e-12);
}

TEST(UnionMoments, AgreeWithASampleOfPoints) {
  const std::vector<Sphere> spheres{{{0.0, 0.0, 0.0}, 1.0},
                                    {{0.9, 0.2, 0.1}, 0.8},
                                    {{0.3, 0.9, -0.2}, 0.7},
                                    {{0.4, 0.3, 0.8}, 0.6}};
  const UnionMoments m = union_moments(spheres);
  RandomStream random(7);
  const Vec3 lower(-1.1, -1.1, -1.1), upper(1.8, 1.7, 1.5);
  const double box = (upper - lower).prod();
  const int n = 1000000;
  int inside = 0;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int k = 0; k < n; ++k) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = random.uniform(lower[a], upper[a]);
    bool in = false;
    for (const Sphere& s : spheres) in = in || (x - s.position).squaredNorm() < s.radius * s.radius;
    if (!in) continue;
    ++inside;
    first += x;
    second += x * x.transpose();
  }
  const double p = static_cast<double>(inside) / n;
  // Five standard errors of a proportion, of a mean and of second moments of points in the union.
  EXPECT_NEAR(m.volume, p * box, 5.0 * box * std::sqrt(p * (1.0 - p) / n));
  const Vec3 mean = first / inside;
  EXPECT_LT((m.centroid - mean).norm(), 5.0 * std::sqrt(3.0 * 0.5 / inside));
  second = second / inside - mean * mean.transpose();
  EXPECT_LT((m.second / m.volume - second).norm(), 5.0 * std::sqrt(9.0 * 0.5 / inside));
}

TEST(UnionMoments, DoNotDependOnHowTheShapeIsTurned) {
  const std::vector<Sphere> spheres{{{0.0, 0.0, 0.0}, 1.0},
                                    {{1.1, 0.0, 0.0}, 0.9},
                                    {{0.4, 0.9, 0.0}, 0.8},
                                    {{0.5, 0.4, 0.7}, 0.5}};
  const UnionMoments straight = union_moments(spheres);
  Eigen::Matrix3d turn;  // a rotation by the Cayley transform of (0.3, -0.8, 0.5)
  const Vec3 w(0.3, -0.8, 0.5);
  Eigen::Matrix3d skew;
  skew << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  turn = (identity - skew).inverse() * (identity + skew);
  std::vector<Sphere> turned;
  for (const Sphere& s : spheres) turned.push_back({turn * s.position, s.radius});
  const UnionMoments m = union_moments(turned);
  EXPECT_NEAR(m.volume, straight.volume, 1e-10 * straight.volume);
  EXPECT_LT((m.centroid - turn * straight.centroid).norm(), 1e-10);
  EXPECT_LT((m.second - turn * straight.second * turn.transpose()).norm(), 1e-10);
}

TEST(ClumpForm, OfOneSphereIsTheUnitSphere) {
  const ClumpForm form = clump_form({"ball", {{{3, 4, 5}, 0.02}}});
  EXPECT_NEAR(form.spheres[0].radius, 1.0, 1e-14);
  EXPECT_LT(form.spheres[0].position.norm(), 1e-14);
  EXPECT_LT((form.inertia - Vec3::Constant(0.4)).norm(), 1e-14);
}

TEST(ClumpForm, LiesInItsPrincipalAxesWithTheVolumeOfTheUnitSphere) {
  const ClumpShape shape{"any", {{{1, 2, 3}, 1.0}, {{1.8, 2.2, 3.4}, 0.7}, {{0.9, 2.9, 2.8}, 0.6}}};
  const ClumpForm form = clump_form(shape);
  const UnionMoments m = union_moments(form.spheres);
  EXPECT_NEAR(m.volume, 4.0 / 3.0 * kPi, 1e-9);
  EXPECT_LT(m.centroid.norm(), 1e-10);
  for (int k = 0; k < 3; ++k) {
    const double other = m.second.trace() - m.second(k, k);
    EXPECT_NEAR(form.inertia[k], other / m.volume, 1e-9);
    EXPECT_NEAR(m.second(k, (k + 1) % 3), 0.0, 1e-9);
  }
  EXPECT_LE(form.inertia[0], form.inertia[1]);
  EXPECT_LE(form.inertia[1], form.inertia[2]);
}

TEST(ClumpForm, RefusesWhatIsNoBody) {
  EXPECT_THROW(clump_form({"empty", {}}), InputError);
  EXPECT_THROW(clump_form({"flat", {{{0, 0, 0}, 0.0}}}), InputError);
  EXPECT_THROW(clump_form({"apart", {{{0, 0, 0}, 1.0}, {{3, 0, 0}, 1.0}}}), InputError);
}

TEST(ShippedClumps, Sinter3HasConstituentsOfSeventyPerCentOfTheEquivalentRadius) {
  const ClumpForm form = clump_form(shipped_clumps().front());
  EXPECT_EQ(shipped_clumps().front().name, "sinter_3");
  ASSERT_EQ(form.spheres.size(), 3u);
  const double lens = kPi * (4.0 + 1.75) * 0.25 * 0.25 / 12.0;
  EXPECT_NEAR(form.smallest_radius, std::cbrt(1.0 / (3.0 - 3.0 * lens / (4.0 / 3.0 * kPi))), 1e-9);
  EXPECT_NEAR(form.smallest_radius, 0.70, 0.002);
}

}  // namespace
}  // namespace repose::scene
