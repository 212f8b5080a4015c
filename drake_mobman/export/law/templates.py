"""The files that a controller is written to, with `@field@`s to be filled in."""

HEADER = """\
/* @name@: @about@
 *
 * The controller of a mobile manipulator, written by drake_mobman @version@: from the
 * end effector's command and what is measured, to commands for base and joints.
 * C99; needs nothing but libm, allocates nothing, keeps its state in a struct.
 *
 *   @name@_state state;
 *   @name@_start(&state, &input);            once
 *   @name@_step(&state, &input, &output);    every @NAME@_PERIOD seconds
 *
 * A command that is not finite or out of range becomes a bounded stop, and so does a
 * measurement that is not finite. No output is ever NaN or infinite.
 * This is no safety function.
 */
#ifndef @NAME@_H
#define @NAME@_H

#define @NAME@_PERIOD @period@ /* [s] */

/* What @name@_start and @name@_step return. */
enum {
  @NAME@_OK = 0,
  @NAME@_NOT_MEASURED = 1, /* A measurement is not finite: the last one is used. */
  @NAME@_STOPPED = 2       /* No command can be worked out: all are zero. */
};

typedef struct {
@inputs@
} @name@_input;

typedef struct {
@outputs@
} @name@_output;

typedef struct {
  double x[@num_state@ + 1];
  double measured[@num_measured@ + 1]; /* What was measured last. */
  int begun;
} @name@_state;

int @name@_start(@name@_state *state, const @name@_input *input);
int @name@_step(@name@_state *state, const @name@_input *input, @name@_output *output);

#endif
"""

SOURCE = """\
/* See @name@.h. Written by drake_mobman @version@; not to be changed by hand. */
#include "@name@.h"

#include <math.h>
#include <string.h>

#ifdef __FAST_MATH__
#error "this code looks for NaN and infinity: compile it without -ffast-math"
#endif

enum {
  STATE = @num_state@,
  INPUTS = @num_inputs@,
  COMMAND = INPUTS - @num_measured@,
  MEASURED = @num_measured@,
  OUTPUTS = @num_outputs@
};

/* in: the state, the inputs; out: the outputs, the next state. */
@step@
/* in: the state before the start, the inputs; out: the state at the start. */
@begin@
static int all_finite(const double *x, int n)
{
  int i;
  for (i = 0; i < n; ++i)
    if (!isfinite(x[i])) return 0;
  return 1;
}

/* Takes the inputs; where a measurement is not finite, the last one, and a command
 * that the guard stops. */
static int taken(@name@_state *state, const @name@_input *input, double *in)
{
@flat_inputs@
  if (all_finite(in + COMMAND, MEASURED)) {
    memcpy(state->measured, in + COMMAND, MEASURED * sizeof(double));
    return @NAME@_OK;
  }
  memcpy(in + COMMAND, state->measured, MEASURED * sizeof(double));
  in[0] = NAN;
  return @NAME@_NOT_MEASURED;
}

int @name@_start(@name@_state *state, const @name@_input *input)
{
  static const double before[STATE + 1] = {@start@};
  double in[STATE + INPUTS + 1];
  memset(state, 0, sizeof *state);
  memcpy(in, before, STATE * sizeof(double));
  if (taken(state, input, in + STATE) != @NAME@_OK) return @NAME@_NOT_MEASURED;
  initialization(in, state->x);
  state->begun = all_finite(state->x, STATE);
  return state->begun ? @NAME@_OK : @NAME@_STOPPED;
}

int @name@_step(@name@_state *state, const @name@_input *input, @name@_output *output)
{
  double in[STATE + INPUTS + 1], out[OUTPUTS + STATE];
  int status;
  memset(output, 0, sizeof *output);
  if (!state->begun) {
    /* A start that had no measurement begins with the first. */
    status = @name@_start(state, input);
    if (status != @NAME@_OK) return @NAME@_STOPPED;
  }
  status = taken(state, input, in + STATE);
  memcpy(in, state->x, STATE * sizeof(double));
  law(in, out);
  if (!all_finite(out, OUTPUTS + STATE)) return @NAME@_STOPPED;
  memcpy(state->x, out + OUTPUTS, STATE * sizeof(double));
@flat_outputs@
  return status;
}
"""

VECTORS = """\
/* Inputs and outputs of the blocks of @name@ at each tick of a run in Drake. */
enum { COUNT = @count@ };

static const double vectors[COUNT][@num_inputs@ + @num_outputs@] = {
@vectors@
};
"""

TEST = """\
/* Tests @name@.c.
 *
 *   ./test_@name@             against what the blocks put out in Drake
 *   ./test_@name@ random N    with N random inputs, NaN and infinity among them
 *   ./test_@name@ time N      how long a step takes, over N steps
 */
#include "@name@.h"
#include "@name@_vectors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { INPUTS = @num_inputs@, OUTPUTS = @num_outputs@ };

static void fill(@name@_input *input, const double *in)
{
  memcpy(input, in, INPUTS * sizeof(double));
}

static const double tolerance = 1e-9;

static int test_vectors(void)
{
  @name@_state state;
  @name@_input input;
  @name@_output output;
  double out[OUTPUTS], worst = 0.0;
  int i, k;
  fill(&input, vectors[0]);
  if (@name@_start(&state, &input) != @NAME@_OK) {
    printf("no start\\n");
    return 1;
  }
  for (k = 0; k < COUNT; ++k) {
    fill(&input, vectors[k]);
    if (@name@_step(&state, &input, &output) != @NAME@_OK) {
      printf("tick %d: stopped\\n", k);
      return 1;
    }
    memcpy(out, &output, sizeof out);
    for (i = 0; i < OUTPUTS; ++i) {
      const double error = fabs(out[i] - vectors[k][INPUTS + i]);
      if (!(error <= tolerance)) {
        printf("tick %d, output %d: %.17g, not %.17g\\n", k, i, out[i],
               vectors[k][INPUTS + i]);
        return 1;
      }
      if (error > worst) worst = error;
    }
  }
  printf("%d ticks, largest difference %.3g\\n", COUNT, worst);
  return 0;
}

/* xorshift64*: the same numbers everywhere. */
static unsigned long long seed = 88172645463325252ULL;

static double uniform(void)
{
  seed ^= seed >> 12;
  seed ^= seed << 25;
  seed ^= seed >> 27;
  return (double)((seed * 2685821657736338717ULL) >> 11) / 9007199254740992.0;
}

static double any(void)
{
  static const double special[] = {NAN,    INFINITY, -INFINITY, 0.0,
                                   -0.0,   1e308,    -1e308,    1e-308,
                                   5e-324, 1.0,      -1.0,      3.14159265358979};
  const double x = uniform();
  if (x < 0.05) return special[(int)(uniform() * 12.0)];
  if (x < 0.1) return ldexp(uniform() - 0.5, (int)(uniform() * 2000.0) - 1000);
  return 8.0 * (uniform() - 0.5);
}

static int test_random(long count)
{
  @name@_state state;
  @name@_input input;
  @name@_output output;
  double in[INPUTS], out[OUTPUTS];
  long k, stopped = 0;
  int i;
  memset(&state, 0, sizeof state);
  for (k = 0; k < count; ++k) {
    for (i = 0; i < INPUTS; ++i) in[i] = any();
    fill(&input, in);
    if (k % 1000 == 0) @name@_start(&state, &input);
    if (@name@_step(&state, &input, &output) != @NAME@_OK) ++stopped;
    memcpy(out, &output, sizeof out);
    for (i = 0; i < OUTPUTS; ++i) {
      if (!isfinite(out[i])) {
        printf("random input %ld: output %d is not finite\\n", k, i);
        return 1;
      }
    }
  }
  printf("%ld random inputs, %ld stopped, all outputs finite\\n", count, stopped);
  return 0;
}

static int time_steps(long count)
{
  @name@_state state;
  @name@_input input;
  @name@_output output;
  volatile double sum = 0.0;
  const clock_t begin = clock();
  long k;
  fill(&input, vectors[0]);
  @name@_start(&state, &input);
  for (k = 0; k < count; ++k) {
    fill(&input, vectors[k % COUNT]);
    @name@_step(&state, &input, &output);
    sum += output.base_command_smoothed[0];
  }
  printf("%.4f us a step\\n", 1e6 * (double)(clock() - begin) / CLOCKS_PER_SEC / count);
  return 0;
}

int main(int argc, char **argv)
{
  const long count = argc > 2 ? atol(argv[2]) : 0;
  if (argc == 1) return test_vectors();
  if (count > 0 && strcmp(argv[1], "random") == 0) return test_random(count);
  if (count > 0 && strcmp(argv[1], "time") == 0) return time_steps(count);
  printf("usage: %s [random N | time N]\\n", argv[0]);
  return 2;
}
"""

MAKEFILE = """\
# make test: compiles the controller, and tests it.
CC = gcc
CFLAGS = -std=c99 -O2 -Wall -Wextra -Werror -pedantic

test_@name@: test_@name@.c @name@.c @name@.h @name@_vectors.h
\t$(CC) $(CFLAGS) -o $@ test_@name@.c @name@.c -lm

.PHONY: test clean
test: test_@name@
\t./test_@name@
\t./test_@name@ random 1000000

clean:
\trm -f test_@name@
"""
