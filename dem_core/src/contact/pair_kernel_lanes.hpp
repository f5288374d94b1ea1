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

template <class R>
[[gnu::always_inline]] inline LawLanes<R> read_laws(const PairBatch& batch,
                                                    const TouchingPair (&pairs)[kLanes<R>]) {
  if (batch.materials == 1) {
    const PairLaw& law = *batch.laws;
    return {law.e_eff,   law.g_eff,     law.mu_s,      law.mu_r,    law.gamma_n,
            law.gamma_t, law.rolling_k, law.rolling_c, law.cohesion};
  }
  const double* rows[3][kLanes<R>];
  for (std::size_t k = 0; k < kLanes<R>; ++k) {
    const PairLaw& law =
        batch.laws[batch.material[pairs[k].i] * batch.materials + batch.material[pairs[k].j]];
    rows[0][k] = &law.e_eff;
    rows[1][k] = &law.mu_r;
    rows[2][k] = &law.rolling_c;
  }
  static_assert(offsetof(PairLaw, e_eff) == 0 && offsetof(PairLaw, g_eff) == 8 &&
                offsetof(PairLaw, mu_s) == 24 && offsetof(PairLaw, mu_r) == 32 &&
                offsetof(PairLaw, gamma_n) == 40 && offsetof(PairLaw, gamma_t) == 48 &&
                offsetof(PairLaw, rolling_k) == 56 && offsetof(PairLaw, rolling_c) == 64 &&
                offsetof(PairLaw, cohesion) == 72 && sizeof(PairLaw) == 96);
  const Row<R> first = read_rows(rows[0]);
  const Row<R> second = read_rows(rows[1]);
  const Row<R> third = read_rows(rows[2]);
  return {first.a, first.b, first.d, second.a, second.b, second.c, second.d, third.a, third.b};
}

/// One block of contacts, of which the first `count` are real and the others repeat the last.
template <class R, class Energies>
[[gnu::always_inline]] inline void add_block(const PairBatch& batch,
                                             const TouchingPair (&pairs)[kLanes<R>],
                                             std::size_t first, std::size_t count,
                                             DeepestPair& deepest, Energies& sum) {
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
  Energies energies;
  const ForceLanes<R> force = contact_law(
      batch.model, read_laws<R>(batch, pairs),
      bodies_of_pair(i.radius, i.inv_mass, j.radius, j.inv_mass), now, batch.dt, history, energies);
  if constexpr (std::is_same_v<Energies, ContactEnergies>) {
    kept_rest.c = energies.stored_j();
    sum += energies;
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

template <class R, class Energies>
[[gnu::always_inline]] inline void add_batch(const PairBatch& batch, DeepestPair& deepest,
                                             Energies& sum) {
  constexpr std::size_t n = kLanes<R>;
  for (std::size_t first = 0; first < batch.count; first += n) {
    const std::size_t count = batch.count - first < n ? batch.count - first : n;
    TouchingPair pairs[n];
    for (std::size_t k = 0; k < n; ++k) pairs[k] = batch.pairs[first + (k < count ? k : count - 1)];
    add_block<R>(batch, pairs, first, count, deepest, sum);
  }
}

}  // namespace repose::dem::detail
