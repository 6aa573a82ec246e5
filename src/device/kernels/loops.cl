// Loops over items of arrays, which also compile as C: src/device/loops.c includes this file. LOOP() and the parts of its list declare the
// numbers and arrays that a loop reads and writes, in the order of the table there; i is the item.

// ---- choices and masks ----

// Sets z = x where the mask is not 0, and z = y elsewhere.
LOOP(choose, IN(mask) IN(x) IN(y) OUT(z)) { z[i] = mask[i] != 0 ? x[i] : y[i]; }
END

// Computes y = product + slope x where the mask is not 0, and y = x elsewhere.
LOOP(masked_sum, IN(mask) IN(slope) IN(x) IN(product) OUT(y)) { y[i] = mask[i] != 0 ? product[i] + slope[i] * x[i] : x[i]; }
END

// Takes the third of three numbers a cell, over its weight.
LOOP(take_third, NUM(weighted) IN(x) IN(weight) OUT(y)) { y[i] = x[3 * i + 2] / (weighted != 0 ? weight[3 * i + 2] : 1); }
END

// Replaces the c rates of a cell: along the fault by 1 if all are 0, else by 0; across it by 1 if that is 0.
LOOP(mark_sticking, NUM(components) OUT(x))
{
  const int c = (int)components, plane = c < 2 ? c : 2;
  int sticks = 1;

  for (int k = 0; k < plane; k++) sticks = sticks && x[c * i + k] == 0;
  for (int k = 0; k < plane; k++) x[c * i + k] = sticks ? 1 : 0;
  for (int k = plane; k < c; k++) x[c * i + k] = x[c * i + k] == 0 ? 1 : 0;
}
END

// Sets e to 0 where the mark is not 1.
LOOP(drop_unmarked, IN(mark) OUT(e))
{
  if (mark[i] != 1) e[i] = 0;
}
END

// Copies c numbers of each block, from `start` on, to the blocks of another array; place_block() copies them back.
LOOP(take_block, NUM(c) NUM(block) NUM(start) IN(w) OUT(x))
{
  for (int k = 0; k < (int)c; k++) x[(int)c * i + k] = w[(int)block * i + (int)start + k];
}
END

LOOP(place_block, NUM(c) NUM(block) NUM(start) IN(x) OUT(w))
{
  for (int k = 0; k < (int)c; k++) w[(int)block * i + (int)start + k] = x[(int)c * i + k];
}
END

// ---- the cone of cells with one component ----

LOOP(cone_natural, NUM(omega) IN(x) IN(g) IN(q) IN(dq) IN(rho) OUT(F) OUT(mask) OUT(slope))
{
  PetscReal slides, more;

  F[i] = SlipConeResidual(omega, x[i], g[i], q[i], dq[i], rho[i], &slides, &more);
  mask[i] = slides;
  slope[i] = more;
}
END

LOOP(cone_finish, NUM(omega) IN(g) IN(q) IN(rho) OUT(x) OUT(r))
{
  x[i] = SlipConeStop(omega, x[i], g[i], q[i], rho[i]);
  r[i] = SlipConeReaction(omega, x[i], g[i], q[i]);
}
END

// Computes the reaction of a state whose F_s is f.
LOOP(cone_reaction, IN(x) IN(q) IN(f) OUT(r)) { r[i] = SlipConeReaction(1, x[i], -f[i], q[i]); }
END

// Stops at 0 the cells whose motion a step from one point to another would reverse, and counts them.
SUMS(cone_turn, 1, IN(q) IN(from) OUT(to))
{
  const int turns = SlipConeTurns(q[i], from[i], to[i]);

  to[i] = turns ? 0 : to[i];
  mine[0] += turns;
}
END_SUMS(1)

// ---- explicit steps, src/ts/moreau.c ----

LOOP(moreau_first, NUM(weight) IN(p) IN(before) IN(f) OUT(expected) OUT(force))
{
  expected[i] = weight == 1 ? p[i] : weight * p[i] + (1 - weight) * before[i];
  force[i] = f[i] - expected[i];
}
END

LOOP(moreau_second, NUM(share) IN(f) IN(p) IN(expected) IN(before) OUT(force) OUT(end))
{
  force[i] = f[i] - 2 * p[i] + expected[i];
  end[i] = p[i] + share * (p[i] - before[i]);
}
END

LOOP(moreau_error, NUM(h) NUM(share) NUM(slope) IN(k0) IN(k1) IN(k2) IN(w0) IN(w2) IN(mark) OUT(e))
{
  if (mark[i] != 2)
    e[i] = share * (k2[i] - k0[i]) - (slope != 0 ? slope * (k0[i] - k1[i]) : 0);
  else
    e[i] = 2.0 / 3.0 * (w2[i] - w0[i] - 0.5 * h * (k0[i] + k2[i]));
}
END
