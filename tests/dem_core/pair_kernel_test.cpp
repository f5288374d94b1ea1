// The kernels for different processors give the same bits, in every variant of the law.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>

#include "contact/contact_evaluation.hpp"
#include "contact/pair_kernel.hpp"
#include "contact/wall_contacts.hpp"
#include "repose/base/random.hpp"
#include "two_bodies.hpp"

namespace repose::dem {
namespace {

/// Touching pairs with all that a kernel reads and writes.
struct Bench {
  std::vector<Motion> motion;
  std::vector<Spin> spin;
  std::vector<Load> load;
  std::vector<std::int32_t> material;
  std::vector<Contact> contacts;
  std::vector<PairLaw> laws;
  std::int32_t materials = 1;
  std::vector<TouchingPair> pairs;
  scene::ContactModel model;
  double dt = 1e-5;
  double period = 0.0;  ///< of x; 0 for none

  PairBatch batch() {
    PairBatch b{};
    b.motion = motion.data()->x.data();
    b.spin = spin.data()->w.data();
    b.load = load.data()->force.data();
    b.material = material.data();
    b.contacts = contacts.data()->history.slip.data();
    b.laws = laws.data();
    b.materials = materials;
    b.model = model;
    b.dt = dt;
    b.periodic = period > 0.0;
    for (int k = 0; k < 3; ++k) {
      b.length[k] = k == 0 ? period : 0.0;
      b.half[k] = k == 0 && period > 0.0 ? 0.5 * period : 1e300;
    }
    b.pairs = pairs.data();
    b.count = pairs.size();
    return b;
  }
};

Vec3 random_vector(RandomStream& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

/// A chain of spheres, each touching the next two; histories from none to far beyond slip, among
/// them some that leave the tangent plane, normal speeds of both signs.
Bench chain(const scene::ContactModel& model, std::int32_t materials, double period,
            std::size_t pairs, std::uint64_t seed) {
  RandomStream random(seed);
  Bench bench;
  bench.model = model;
  bench.materials = materials;
  bench.period = period;
  for (std::int32_t a = 0; a < materials; ++a)
    for (std::int32_t b = 0; b < materials; ++b) {
      const std::int32_t which = a + b;  // symmetric
      scene::Case c = empty_case({.restitution = which == 1 ? 1.0 : 0.5,
                                  .mu_s = which == 2 ? 0.0 : 0.4,
                                  .mu_r = which == 3 ? 0.0 : 0.2});
      c.pairs[0].cohesion_energy_density_j_m3 = which == 1 ? 1e4 : 0.0;
      bench.laws.push_back(make_pair_law(c.materials[0], c.materials[0], c.pairs[0], model));
    }
  const std::size_t spheres = pairs / 2 + 3;
  for (std::size_t s = 0; s < spheres; ++s) {
    const double radius = random.uniform(0.004, 0.006);
    const double mass = sphere_mass(radius, 2500.0);
    // The second next touches as well: a zigzag.
    Vec3 x(0.0037 * static_cast<double>(s), s % 2 == 0 ? 0.0 : 0.0065, 0.0);
    x += random_vector(random, 1e-4);
    if (period > 0.0) x.x() -= period * std::floor(x.x() / period);
    bench.motion.push_back({x, radius, random_vector(random, 0.5), 1.0 / mass});
    bench.spin.push_back({random_vector(random, 30.0), 2.5 / (mass * radius * radius)});
    bench.material.push_back(static_cast<std::int32_t>(s) % materials);
    bench.load.push_back({});
  }
  for (std::size_t p = 0; p < pairs; ++p) {
    const auto i = static_cast<std::int32_t>(p / 2);
    const std::int32_t j = i + 1 + static_cast<std::int32_t>(p % 2);
    bench.pairs.push_back({i, j, static_cast<std::int32_t>(pairs - 1 - p)});
    Contact contact;
    const double size = p % 5 == 0 ? 0.0 : 1e-6 * static_cast<double>(p % 5);
    contact.history.slip = random_vector(random, size);
    contact.history.rolling = random_vector(random, 1e2 * size);
    contact.stored_j = static_cast<double>(p);
    bench.contacts.push_back(contact);
  }
  return bench;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         std::memcmp(static_cast<const void*>(a.data()), static_cast<const void*>(b.data()),
                     a.size() * sizeof(T)) == 0;
}

std::vector<scene::ContactModel> all_models() {
  std::vector<scene::ContactModel> models;
  for (scene::Tail tail : {scene::Tail::keep, scene::Tail::clip})
    for (scene::RollingModel rolling : {scene::RollingModel::c, scene::RollingModel::a})
      for (scene::RollingStiffness stiffness :
           {scene::RollingStiffness::ai, scene::RollingStiffness::kt})
        for (scene::Compatibility compatibility :
             {scene::Compatibility::none, scene::Compatibility::liggghts})
          models.push_back({tail, rolling, stiffness, compatibility});
  return models;
}

std::string name_of(const scene::ContactModel& model) {
  return fmt::format("tail {} rolling {} stiffness {} compatibility {}",
                     static_cast<int>(model.tail), static_cast<int>(model.rolling),
                     static_cast<int>(model.rolling_stiffness),
                     static_cast<int>(model.compatibility));
}

void expect_same_as_scalar(const PairKernel& kernel) {
  std::uint64_t seed = 1;
  for (const scene::ContactModel& model : all_models())
    for (std::int32_t materials : {1, 3})
      for (double period : {0.0, 0.1})
        for (std::size_t pairs : {1u, 2u, 3u, 5u, 8u, 200u}) {
          Bench scalar = chain(model, materials, period, pairs, ++seed);
          Bench wide = scalar;
          DeepestPair of_scalar{0.0, -1};
          DeepestPair of_wide{0.0, -1};
          usable_pair_kernels().front()->add_forces(scalar.batch(), of_scalar);
          kernel.add_forces(wide.batch(), of_wide);
          EXPECT_TRUE(same_bits(scalar.load, wide.load))
              << kernel.name << ", " << name_of(model) << ", " << pairs;
          EXPECT_TRUE(same_bits(scalar.contacts, wide.contacts)) << name_of(model) << ", " << pairs;
          EXPECT_EQ(of_scalar.ratio, of_wide.ratio);
          EXPECT_EQ(of_scalar.pair, of_wide.pair);
          EXPECT_GT(of_scalar.ratio, 0.0);
        }
}

TEST(PairKernel, ForEachProcessorGivesTheScalarBits) {
  ASSERT_GE(usable_pair_kernels().size(), 2u);
  for (const PairKernel* kernel : usable_pair_kernels()) expect_same_as_scalar(*kernel);
}

TEST(PairKernel, WithEnergiesGivesTheScalarBits) {
  for (const scene::ContactModel& model : all_models()) {
    Bench plain = chain(model, 3, 0.0, 50, 99);
    Bench asked = plain;
    DeepestPair deepest{0.0, -1};
    ExactEnergies sum;
    usable_pair_kernels().front()->add_forces(plain.batch(), deepest);
    add_forces_with_energies(asked.batch(), deepest, sum);
    EXPECT_TRUE(same_bits(plain.load, asked.load)) << name_of(model);
    double stored = 0.0;
    for (const Contact& contact : asked.contacts) stored += contact.stored_j;
    EXPECT_NEAR(stored, sum.value().stored_j(), 1e-12 * std::abs(stored));
    EXPECT_GT(sum.normal_j.value(), 0.0);
  }
}

TEST(PairKernel, AddsTheLawsForcesOfEachPairInOrder) {
  for (const scene::ContactModel& model : all_models()) {
    Bench bench = chain(model, 3, 0.0, 60, 5);
    std::vector<Load> expected(bench.load.size());
    std::vector<ContactHistory> histories;
    for (const TouchingPair& pair : bench.pairs) {
      const auto i = static_cast<std::size_t>(pair.i);
      const auto j = static_cast<std::size_t>(pair.j);
      const Motion& a = bench.motion[i];
      const Motion& b = bench.motion[j];
      const Vec3 offset = b.x - a.x;
      const ContactKinematics now = pair_kinematics(model, bench.dt, offset, offset.norm(), a, b,
                                                    bench.spin[i].w, bench.spin[j].w);
      ContactHistory history = bench.contacts[static_cast<std::size_t>(pair.contact)].history;
      const ContactForce f =
          hertz_mindlin(model,
                        bench.laws[static_cast<std::size_t>(bench.material[i] * bench.materials +
                                                            bench.material[j])],
                        sphere_sphere(a.radius, 1.0 / a.inv_mass, b.radius, 1.0 / b.inv_mass), now,
                        bench.dt, history);
      const Vec3 turning = cross(now.normal, f.tangential);
      expected[i].force += f.force;
      expected[j].force -= f.force;
      expected[i].torque += (a.radius - 0.5 * now.overlap) * turning + f.rolling_torque;
      expected[j].torque += (b.radius - 0.5 * now.overlap) * turning - f.rolling_torque;
      histories.push_back(history);
    }
    DeepestPair deepest{0.0, -1};
    pair_kernel().add_forces(bench.batch(), deepest);
    double size = 0.0;
    for (const Load& load : expected) size = std::max(size, load.force.norm());
    // 1/(1/m) for m, and the length of the offset: some roundings of the largest force.
    for (std::size_t s = 0; s < expected.size(); ++s) {
      EXPECT_LT((bench.load[s].force - expected[s].force).norm(), 1e-12 * size) << name_of(model);
      EXPECT_LT((bench.load[s].torque - expected[s].torque).norm(), 1e-14 * size);
    }
    for (std::size_t p = 0; p < histories.size(); ++p) {
      const Contact& contact = bench.contacts[static_cast<std::size_t>(bench.pairs[p].contact)];
      EXPECT_LT((contact.history.slip - histories[p].slip).norm(), 1e-16);
      EXPECT_EQ(contact.stored_j, static_cast<double>(histories.size() - 1 - p));  // not asked for
    }
  }
}

/// Contacts of the spheres of a chain with walls of which one moves.
struct WallBench {
  Bench spheres;
  std::vector<WallContact> contacts;
  std::vector<std::int32_t> sphere_of, wall_of;
  std::vector<const PairLaw*> law_of;
  struct alignas(32) Row {
    double v[4];
  };
  std::vector<Row> twists, forces;

  WallBatch batch() {
    return {.motion = spheres.motion.data()->x.data(),
            .spin = spheres.spin.data()->w.data(),
            .contacts = contacts.data()->normal.data(),
            .twists = twists.data()->v,
            .forces = forces.data()->v,
            .spheres = sphere_of.data(),
            .walls = wall_of.data(),
            .laws = law_of.data(),
            .model = spheres.model,
            .dt = spheres.dt,
            .count = contacts.size()};
  }
};

WallBench at_walls(const scene::ContactModel& model, std::size_t count, std::uint64_t seed) {
  RandomStream random(seed);
  WallBench bench;
  bench.spheres = chain(model, 3, 0.0, 2 * count, seed);
  bench.twists = {{{0, 0, 0, 0}}, {{0, 0, 0, 0}}, {{0.1, -0.2, 0.3, 0}}, {{3, 2, -1, 0}}};
  bench.forces.resize(3 * count);
  for (std::size_t c = 0; c < count; ++c) {
    WallContact contact{};
    contact.normal = random_vector(random, 1.0).normalized();
    contact.overlap = random.uniform(1e-6, 1e-4);
    contact.sphere = static_cast<std::int32_t>(c);
    contact.wall = static_cast<std::int32_t>(c % 2);
    contact.contact = bench.spheres.contacts[c];
    bench.contacts.push_back(contact);
    bench.sphere_of.push_back(contact.sphere);
    bench.wall_of.push_back(contact.wall);
    bench.law_of.push_back(&bench.spheres.laws[c % bench.spheres.laws.size()]);
  }
  return bench;
}

bool same_contacts(const std::vector<WallContact>& a, const std::vector<WallContact>& b) {
  for (std::size_t c = 0; c < a.size(); ++c)
    if (std::memcmp(static_cast<const void*>(&a[c].contact),
                    static_cast<const void*>(&b[c].contact), sizeof(Contact)) != 0)
      return false;
  return true;
}

TEST(PairKernel, ForEachProcessorGivesTheScalarBitsAtWalls) {
  std::uint64_t seed = 1000;
  for (const scene::ContactModel& model : all_models())
    for (std::size_t count : {1u, 2u, 3u, 5u, 9u, 64u}) {
      WallBench scalar = at_walls(model, count, ++seed);
      usable_pair_kernels().front()->find_forces(scalar.batch());
      for (const PairKernel* kernel : usable_pair_kernels()) {
        WallBench wide = at_walls(model, count, seed);
        kernel->find_forces(wide.batch());
        EXPECT_TRUE(same_bits(scalar.forces, wide.forces)) << kernel->name << name_of(model);
        EXPECT_TRUE(same_contacts(scalar.contacts, wide.contacts)) << kernel->name;
      }
      WallBench asked = at_walls(model, count, seed);
      ExactEnergies sum;
      find_forces_with_energies(asked.batch(), sum);
      EXPECT_TRUE(same_bits(scalar.forces, asked.forces)) << name_of(model);
      EXPECT_GT(sum.normal_j.value(), 0.0);
      for (std::size_t c = 0; c < count; ++c) {  // the law itself, contact by contact
        const WallBench before = at_walls(model, count, seed);
        const Motion& sphere = before.spheres.motion[c];
        const Twist twist = c % 2 == 0 ? Twist{} : Twist{{0.1, -0.2, 0.3}, {3, 2, -1}};
        ContactHistory history = before.contacts[c].contact.history;
        const ContactForce f = hertz_mindlin(
            model, *before.law_of[c], sphere_wall(sphere.radius, 1.0 / sphere.inv_mass),
            wall_kinematics(before.spheres.dt, before.contacts[c].normal,
                            before.contacts[c].overlap, sphere, before.spheres.spin[c].w, twist),
            before.spheres.dt, history);
        const double size = f.force.norm();
        const auto& row = scalar.forces[3 * c].v;
        EXPECT_LE((Vec3(row[0], row[1], row[2]) - f.force).norm(), 1e-12 * size);
        EXPECT_EQ(row[3], f.normal);
        if (count > 9) break;  // the same for all
      }
    }
}

}  // namespace
}  // namespace repose::dem
