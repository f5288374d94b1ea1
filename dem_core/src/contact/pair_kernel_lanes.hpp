// The loop over touching pairs in lanes; included by one source for each processor.
#pragma once

#include "contact/pack.hpp"
#include "contact/pair_kernel.hpp"
#include "repose/dem/detail/law_lanes.hpp"

namespace repose::dem::detail {

template <class R>
[[gnu::always_inline]] inline Lanes3<R> nearest_image(const PairBatch& batch, Lanes3<R> d) {
  const auto wrap = [&batch](R x, int k) __attribute__((always_inline)) {
    x = chosen(x > batch.half[k], R(x - batch.length[k]), x);
    return chosen(x < -batch.half[k], R(x + batch.length[k]), x);
  };
  if (batch.periodic) d = {wrap(d.x, 0), wrap(d.y, 1), wrap(d.z, 2)};
  return d;
}

static_assert(offsetof(PairLaw, e_eff) == 0 && offsetof(PairLaw, g_eff) == 8 &&
              offsetof(PairLaw, mu_s) == 24 && offsetof(PairLaw, mu_r) == 32 &&
              offsetof(PairLaw, gamma_n) == 40 && offsetof(PairLaw, gamma_t) == 48 &&
              offsetof(PairLaw, rolling_k) == 56 && offsetof(PairLaw, rolling_c) == 64 &&
              offsetof(PairLaw, cohesion) == 72 && sizeof(PairLaw) == 96);

template <class R>
[[gnu::always_inline]] inline LawLanes<R> read_laws(const PairLaw* const (&laws)[kLanes<R>]) {
  const double* rows[3][kLanes<R>];
  for (std::size_t k = 0; k < kLanes<R>; ++k) {
    rows[0][k] = &laws[k]->e_eff;
    rows[1][k] = &laws[k]->mu_r;
    rows[2][k] = &laws[k]->rolling_c;
  }
  const Row<R> first = read_rows(rows[0]);
  const Row<R> second = read_rows(rows[1]);
  const Row<R> third = read_rows(rows[2]);
  return {first.a, first.b, first.d, second.a, second.b, second.c, second.d, third.a, third.b};
}

template <class R>
[[gnu::always_inline]] inline LawLanes<R> laws_of(const PairBatch& batch,
                                                  const TouchingPair (&pairs)[kLanes<R>]) {
  if (batch.materials == 1) {
    const PairLaw& law = *batch.laws;
    return {law.e_eff,   law.g_eff,     law.mu_s,      law.mu_r,    law.gamma_n,
            law.gamma_t, law.rolling_k, law.rolling_c, law.cohesion};
  }
  const PairLaw* laws[kLanes<R>];
  for (std::size_t k = 0; k < kLanes<R>; ++k)
    laws[k] =
        batch.laws + batch.material[pairs[k].i] * batch.materials + batch.material[pairs[k].j];
  return read_laws<R>(laws);
}

/// What a contact tells a sum of energies.
template <class Sum>
using OneOf = std::conditional_t<std::is_same_v<Sum, NoEnergies>, NoEnergies, ContactEnergies>;

/// One block of contacts, of which the first `count` are real and the others repeat the last.
template <class R, class Sum>
[[gnu::always_inline]] inline void add_block(const PairBatch& batch,
                                             const TouchingPair (&pairs)[kLanes<R>],
                                             std::size_t first, std::size_t count,
                                             DeepestPair& deepest, Sum& sum) {
  constexpr std::size_t n = kLanes<R>;
  const double *x_i[n], *x_j[n], *v_i[n], *v_j[n], *w_i[n], *w_j[n], *slip[n], *rest[n];
  for (std::size_t k = 0; k < n; ++k) {
    x_i[k] = batch.motion + 8 * std::size_t(pairs[k].i);
    x_j[k] = batch.motion + 8 * std::size_t(pairs[k].j);
    v_i[k] = x_i[k] + 4;
    v_j[k] = x_j[k] + 4;
    w_i[k] = batch.spin + 4 * std::size_t(pairs[k].i);
    w_j[k] = batch.spin + 4 * std::size_t(pairs[k].j);
    slip[k] = batch.contacts + 8 * std::size_t(pairs[k].contact);
    rest[k] = slip[k] + 4;
  }
  const Row<R> xi = read_rows(x_i), xj = read_rows(x_j);
  const Row<R> vi = read_rows(v_i), vj = read_rows(v_j);
  const Row<R> wi = read_rows(w_i), wj = read_rows(w_j);
  const Lanes3<R> offset = nearest_image(batch, Lanes3<R>{xj.a - xi.a, xj.b - xi.b, xj.c - xi.c});
  const SphereLanes<R> i{{vi.a, vi.b, vi.c}, {wi.a, wi.b, wi.c}, xi.d, vi.d};
  const SphereLanes<R> j{{vj.a, vj.b, vj.c}, {wj.a, wj.b, wj.c}, xj.d, vj.d};
  const KinematicsLanes<R> now =
      kinematics_of_pair(batch.model, batch.dt, offset, root(squared(offset)), i, j);
  const R smaller = chosen(j.radius < i.radius, j.radius, i.radius);
  const R ratio = now.overlap / smaller;
  if (any(ratio > deepest.ratio))
    for (std::size_t k = 0; k < count; ++k)
      if (lane(ratio, k) > deepest.ratio)
        deepest = {lane(ratio, k), static_cast<std::ptrdiff_t>(first + k)};

  Row<R> kept_slip = read_rows(slip), kept_rest = read_rows(rest);
  HistoryLanes<R> history{{kept_slip.a, kept_slip.b, kept_slip.c},
                          {kept_slip.d, kept_rest.a, kept_rest.b}};
  OneOf<Sum> energies;
  const ForceLanes<R> force = contact_law(
      batch.model, laws_of<R>(batch, pairs),
      bodies_of_pair(i.radius, i.inv_mass, j.radius, j.inv_mass), now, batch.dt, history, energies);
  if constexpr (std::is_same_v<OneOf<Sum>, ContactEnergies>) {
    kept_rest.c = energies.stored_j();
    sum.add(energies);
  }
  const R half = 0.5 * now.overlap;
  const Lanes3<R> turning = cross3(now.normal, force.tangential);
  const Lanes3<R> torque_i = R(i.radius - half) * turning + force.rolling_torque;
  const Lanes3<R> torque_j = R(j.radius - half) * turning - force.rolling_torque;

  // Only now memory changes: blocks of one lane each and of several read and write alike.
  using Four = VectorTypes<4>::InMemory;
  alignas(64) double out[n][20];
  double *force_rows[n], *i_rows[n], *j_rows[n], *slip_rows[n], *rest_rows[n];
  for (std::size_t k = 0; k < n; ++k) {
    force_rows[k] = out[k];
    i_rows[k] = out[k] + 4;
    j_rows[k] = out[k] + 8;
    slip_rows[k] = out[k] + 12;
    rest_rows[k] = out[k] + 16;
  }
  const R zero(0.0);
  write_rows({force.force.x, force.force.y, force.force.z, zero}, force_rows);
  write_rows({torque_i.x, torque_i.y, torque_i.z, zero}, i_rows);
  write_rows({torque_j.x, torque_j.y, torque_j.z, zero}, j_rows);
  write_rows({history.slip.x, history.slip.y, history.slip.z, history.rolling.x}, slip_rows);
  write_rows({history.rolling.y, history.rolling.z, kept_rest.c, kept_rest.d}, rest_rows);
  for (std::size_t k = 0; k < count; ++k) {
    Four* const load_i = reinterpret_cast<Four*>(batch.load + 8 * std::size_t(pairs[k].i));
    Four* const load_j = reinterpret_cast<Four*>(batch.load + 8 * std::size_t(pairs[k].j));
    Four* const contact =
        reinterpret_cast<Four*>(batch.contacts + 8 * std::size_t(pairs[k].contact));
    const Four* const row = reinterpret_cast<const Four*>(out[k]);
    load_i[0] += row[0];
    load_i[1] += row[1];
    load_j[0] -= row[0];
    load_j[1] += row[2];
    contact[0] = row[3];
    contact[1] = row[4];
  }
}

template <class R, class Sum>
[[gnu::always_inline]] inline void add_batch(const PairBatch& batch, DeepestPair& deepest,
                                             Sum& sum) {
  constexpr std::size_t n = kLanes<R>;
  for (std::size_t first = 0; first < batch.count; first += n) {
    const std::size_t count = batch.count - first < n ? batch.count - first : n;
    TouchingPair pairs[n];
    for (std::size_t k = 0; k < n; ++k) pairs[k] = batch.pairs[first + (k < count ? k : count - 1)];
    add_block<R>(batch, pairs, first, count, deepest, sum);
  }
}

/// One block of contacts with walls; those beyond `count` repeat the last.
template <class R, class Sum>
[[gnu::always_inline]] inline void find_block(const WallBatch& batch, std::size_t first,
                                              std::size_t count, Sum& sum) {
  constexpr std::size_t n = kLanes<R>;
  const double *x[n], *v[n], *w[n], *normal[n], *slip[n], *rest[n], *velocity[n], *spin[n];
  const PairLaw* laws[n];
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t c = first + (k < count ? k : count - 1);
    x[k] = batch.motion + 8 * std::size_t(batch.spheres[c]);
    v[k] = x[k] + 4;
    w[k] = batch.spin + 4 * std::size_t(batch.spheres[c]);
    normal[k] = batch.contacts + 16 * c;
    slip[k] = normal[k] + 8;
    rest[k] = normal[k] + 12;
    velocity[k] = batch.twists + 8 * std::size_t(batch.walls[c]);
    spin[k] = velocity[k] + 4;
    laws[k] = batch.laws[c];
  }
  const Row<R> xs = read_rows(x), vs = read_rows(v), ws = read_rows(w), ns = read_rows(normal);
  const Row<R> wall_v = read_rows(velocity), wall_w = read_rows(spin);
  const SphereLanes<R> sphere{{vs.a, vs.b, vs.c}, {ws.a, ws.b, ws.c}, xs.d, vs.d};
  const KinematicsLanes<R> now = kinematics_at_wall(
      batch.dt, Lanes3<R>{ns.a, ns.b, ns.c}, ns.d, Lanes3<R>{xs.a, xs.b, xs.c}, sphere,
      Lanes3<R>{wall_v.a, wall_v.b, wall_v.c}, Lanes3<R>{wall_w.a, wall_w.b, wall_w.c});
  const Row<R> kept_slip = read_rows(slip);
  Row<R> kept_rest = read_rows(rest);
  HistoryLanes<R> history{{kept_slip.a, kept_slip.b, kept_slip.c},
                          {kept_slip.d, kept_rest.a, kept_rest.b}};
  OneOf<Sum> energies;
  const ForceLanes<R> force =
      contact_law(batch.model, read_laws<R>(laws), bodies_at_wall(sphere.radius, sphere.inv_mass),
                  now, batch.dt, history, energies);
  if constexpr (std::is_same_v<OneOf<Sum>, ContactEnergies>) {
    kept_rest.c = energies.stored_j();
    sum.add(energies);
  }
  const Lanes3<R> torque =
      R(sphere.radius - 0.5 * now.overlap) * cross3(now.normal, force.tangential) +
      force.rolling_torque;
  double *forces[n], *torques[n], *rollings[n], *slips[n], *rests[n];
  alignas(64) double beyond[4];  // where the lanes that repeat write
  for (std::size_t k = 0; k < n; ++k) {
    double* const to = batch.forces + 12 * (first + k);
    double* const contact = batch.contacts + 16 * (first + k);
    forces[k] = k < count ? to : beyond;
    torques[k] = k < count ? to + 4 : beyond;
    rollings[k] = k < count ? to + 8 : beyond;
    slips[k] = k < count ? contact + 8 : beyond;
    rests[k] = k < count ? contact + 12 : beyond;
  }
  const R zero(0.0);
  write_rows({force.force.x, force.force.y, force.force.z, force.normal}, forces);
  write_rows({torque.x, torque.y, torque.z, zero}, torques);
  write_rows({force.rolling_torque.x, force.rolling_torque.y, force.rolling_torque.z, zero},
             rollings);
  write_rows({history.slip.x, history.slip.y, history.slip.z, history.rolling.x}, slips);
  write_rows({history.rolling.y, history.rolling.z, kept_rest.c, kept_rest.d}, rests);
}

template <class R, class Sum>
[[gnu::always_inline]] inline void find_batch(const WallBatch& batch, Sum& sum) {
  constexpr std::size_t n = kLanes<R>;
  for (std::size_t first = 0; first < batch.count; first += n)
    find_block<R>(batch, first, batch.count - first < n ? batch.count - first : n, sum);
}

/// The functions of a kernel with this many lanes.
template <class R>
[[gnu::always_inline]] inline void add_forces(const PairBatch& batch, DeepestPair& deepest) {
  NoEnergies none;
  add_batch<R>(batch, deepest, none);
}
template <class R>
[[gnu::always_inline]] inline void find_forces(const WallBatch& batch) {
  NoEnergies none;
  find_batch<R>(batch, none);
}

}  // namespace repose::dem::detail
