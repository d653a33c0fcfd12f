/* Solve a system of `fluid-solver` with MUMPS (sequential, one thread): CPU time of each phase, and how far its
 * solution is from the other one. README.md says how to build it and what the file holds. */
#include <dmumps_c.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now(void)
{
	struct timespec time;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
	return time.tv_sec + 1e-9 * time.tv_nsec;
}

static void *block(FILE *file, size_t size, size_t count)
{
	void *data = malloc(size * count);
	if (!data || fread(data, size, count, file) != count) {
		fprintf(stderr, "the file ends too early, or there is no memory for %zu numbers\n", count);
		exit(2);
	}
	return data;
}

static double phase(DMUMPS_STRUC_C *mumps, int job)
{
	double begin = now();
	mumps->job = job;
	dmumps_c(mumps);
	if (mumps->infog[0] < 0) {
		fprintf(stderr, "MUMPS, job %d: error %d, %d\n", job, mumps->infog[0], mumps->infog[1]);
		exit(3);
	}
	return now() - begin;
}

/* The largest difference of the velocities and of the pressures, relative to the largest of each. */
static void compare(const double *own, const double *other, int64_t n)
{
	double apart[2] = {0, 0}, size[2] = {0, 0};
	for (int64_t k = 0; k < n; k++) {
		int pressure = k % 4 == 3;
		apart[pressure] = fmax(apart[pressure], fabs(own[k] - other[k]));
		size[pressure] = fmax(size[pressure], fabs(other[k]));
	}
	printf("apart: u %.1e, p %.1e\n", apart[0] / size[0], apart[1] / size[1]);
}

int main(int count, char **arguments)
{
	FILE *file = count == 3 ? fopen(arguments[1], "rb") : NULL;
	if (!file) {
		fprintf(stderr, "usage: solve FILE ORDERING (5: METIS, 4: PORD, 3: Scotch, 7: MUMPS chooses)\n");
		return 2;
	}
	int64_t *sizes = block(file, 8, 2), n = sizes[0], entries = sizes[1];
	DMUMPS_STRUC_C mumps;
	memset(&mumps, 0, sizeof mumps);
	mumps.par = 1;
	phase(&mumps, -1);
	mumps.n = n;
	mumps.nnz = entries;
	mumps.irn = block(file, 4, entries);
	mumps.jcn = block(file, 4, entries);
	mumps.a = block(file, 8, entries);
	mumps.rhs = block(file, 8, n);
	double *other = block(file, 8, n);
	for (int k = 0; k < 3; k++)
		mumps.icntl[k] = -1;
	mumps.icntl[6] = atoi(arguments[2]);
	mumps.icntl[13] = 60; /* % more memory than foreseen */
	double analysis = phase(&mumps, 1), factor = phase(&mumps, 2), solve = phase(&mumps, 3);
	printf("%lld unknowns: analysis %.2f, factor %.2f, solve %.2f s; %.0f MB; ", (long long)n, analysis, factor, solve,
	       (double)mumps.infog[21]);
	compare(mumps.rhs, other, n);
	return 0;
}
