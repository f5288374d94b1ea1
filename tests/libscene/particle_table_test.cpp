#include <gtest/gtest.h>

#include <unistd.h>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "sample_case.hpp"

namespace repose::scene {
namespace {

/// A table of particles as CSV, which goes away with the object.
struct Csv {
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("repose_particles_" + std::to_string(::getpid()) + ".csv");
  ParticleTable table;
  explicit Csv(const std::string& text) {
    write_file_atomically(path, text);
    table.location = path.string();
    table.material = "pellet";
    table.content_hash = content_hash(text);
  }
  ~Csv() { std::filesystem::remove(path); }
  std::string refusal() const {
    try {
      load_particles(sample_case(), table);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }
};

TEST(ParticleTable, OfSpheresThatAreBodiesOfTheirOwnIsRead) {
  const Csv csv("x_m,y_m,z_m,radius_m,body\n0,0,0,0.01,4\n0.1,0,0,0.02,5\n");
  const std::vector<Particle> particles = load_particles(sample_case(), csv.table);
  ASSERT_EQ(particles.size(), 2u);
  EXPECT_EQ(particles[1].position, Vec3(0.1, 0, 0));
  EXPECT_EQ(particles[1].radius_m, 0.02);
  EXPECT_EQ(particles[1].material, "pellet");
}

TEST(ParticleTable, OfTheSpheresOfAClumpIsRefused) {
  const Csv csv("x_m,y_m,z_m,radius_m,body\n0,0,0,0.01,4\n0.1,0,0,0.02,5\n0,0,0,0.01,4\n");
  EXPECT_NE(csv.refusal().find("rows 1 and 3 are spheres of one clump, body = 4"),
            std::string::npos)
      << csv.refusal();
}

TEST(ParticleTable, ThatChangedSinceTheCaseWasReadIsRefused) {
  const Csv csv("x_m,y_m,z_m,radius_m\n0,0,0,0.01\n");
  write_file_atomically(csv.path, "x_m,y_m,z_m,radius_m\n0,0,0,0.02\n");
  EXPECT_NE(csv.refusal().find("changed"), std::string::npos) << csv.refusal();
}

}  // namespace
}  // namespace repose::scene
